// Zone setup: makes the contents of a zone before its first entity: static bodies, doors, particle
// systems and the paths over its ground.
#pragma once

#include "server/zone/zone_state.h"

#include <string>

namespace zoned::zone {

/// Once, before the first tick.
void set_up(ZoneState& state);

/// The reason why make_paths() cannot bake the maps of such a zone, or empty, as far as it can be
/// told without baking them.
std::string paths_defect(const ZoneSettings& settings);

/// The paths over the zone's ground, with its doors as they are at state.now, before anybody has
/// asked for one.
void make_paths(ZoneState& state);

}  // namespace zoned::zone
