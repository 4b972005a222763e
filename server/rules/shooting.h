// Shooting: hitscan shots at the world as the shooter's client saw it.
#pragma once

#include "server/rules/game.h"

namespace zoned::rules {

/// A shot from the eye. With Shoot::seen it is fired from the avatar's place after the command's
/// tick, at the world as the client displayed it (RulesContext::ray_cast_as_seen). The decision
/// goes to the shooter and to the client that was hit or narrowly missed. A shot whose tick has not
/// come yet waits for it. Without Shoot::seen it is fired at once and at the world as it is.
void shoot(Game& game, RulesContext& context, const Actor& actor, Payload payload);

/// Fires the shots whose tick has come, of a character of this zone.
void run_shots(Game& game, RulesContext& context, EntityId avatar, CharacterRecord& record);

}  // namespace zoned::rules
