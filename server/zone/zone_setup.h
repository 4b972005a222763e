// Zone setup: makes the contents of a zone before its first entity: static bodies, doors, particle
// systems and the paths over its ground.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Once, before the first tick.
void set_up(ZoneState& state);

/// The paths over the zone's ground, with its doors as they are at state.now, before anybody has
/// asked for one.
void make_paths(ZoneState& state);

}  // namespace zoned::zone
