// Vehicles: players get on what has seats, and off again.
#pragma once

#include "server/rules/game.h"

namespace zoned::rules {

/// COMMAND_RIDE: onto the first free seat of a thing in reach, or (entity 0) off.
void ride(Game& game, RulesContext& context, const Actor& actor, Payload payload);

/// Sets a rider down beside its vehicle, where there is room.
void get_off(RulesContext& context, EntityId avatar);

}  // namespace zoned::rules
