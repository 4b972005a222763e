// Zone platforms: the moving boxes on which bodies rest and ride, and which rays hit.
#pragma once

#include "server/zone/zone_state.h"

#include <cstdint>

namespace zoned::zone {

/// Puts their bodies where they are at `state.now`, and the ground without them for agents.
void add_platforms(ZoneState& state);

/// Platforms that move in this tick or have just stopped.
std::uint32_t moving_platforms(const ZoneState& state);

/// Gives their bodies the velocities that bring them where they are after the step. Returns how
/// many move.
std::uint32_t steer_platforms(ZoneState& state);

}  // namespace zoned::zone
