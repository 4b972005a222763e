// Ragdolls: what is left of a killed character falls as bodies with joints, for a while.
#pragma once

#include "server/rules/game.h"

namespace zoned::rules {

/// A ragdoll takes the place of a character that is about to be hidden; it moves on as the
/// character did. Nothing where the world has no such type.
void fall_as_ragdoll(Game& game, RulesContext& context, EntityId character);

/// Takes it away when its time is over; false then.
bool run_ragdoll(RulesContext& context, EntityId ragdoll, const RagdollRecord& record);

}  // namespace zoned::rules
