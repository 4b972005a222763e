// Zone doors: shut doors are solid for bodies and rays, and push out characters that stand in them.
#pragma once

#include "server/zone/zone_state.h"

#include <cstdint>

namespace zoned::zone {

/// Puts the bodies of those that are shut at the first tick there.
void add_doors(ZoneState& state);

/// Doors that stand other than they do at `state.now`.
std::uint32_t doors_to_turn(const ZoneState& state);

/// Shuts and opens them. A body that sleeps or rests against one wakes. Returns how many.
std::uint32_t turn_doors(ZoneState& state);

}  // namespace zoned::zone
