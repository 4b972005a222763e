// Zone hash: chains the changes of a tick into the zone's hash.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Rows that move or were touched since the last call, all in the first one; and the hashes of
/// agents, places, particles, soft bodies, joints, riders and rules. Returns the number of rows.
std::uint32_t hash_tick(ZoneState& state);

}  // namespace zoned::zone
