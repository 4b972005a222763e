// Levers: entities that players operate by a button; the rules are told of each use.
#pragma once

#include "shared/core/ids.h"

#include <cstdint>

namespace zoned::zone {

struct ZoneState;
class RulesContext;

/// Uses the lever nearest to an avatar that has pressed its button within its reach. A lever of
/// another zone is used there in the next tick.
void use_lever(ZoneState& state, RulesContext& context, EntityId avatar, std::uint16_t pressed);

/// Turns a lever of this zone and tells the rules; nothing where it is gone.
void turn_lever(ZoneState& state, RulesContext& context, EntityId lever, EntityId user);

}  // namespace zoned::zone
