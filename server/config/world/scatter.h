// scatter: places the entities and spawn points of a config on its terrain, by seed.
#pragma once

#include "server/config/text/diagnostics.h"
#include "server/config/world/terrain.h"

#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Expands single placements, then scatter entries, in their order. Needs settings.types and
/// settings.seed. The same config and seed give the same entities. An entity that cannot be placed
/// is a mistake.
void place_entities(const proto::config::Config& config,
                    const Terrain& terrain,
                    Settings& settings,
                    Diagnostics& diagnostics);

/// Fills settings.spawn_points: y is the height of the centre of the tallest character without an
/// agent. Needs settings.types.
void place_spawn_points(const proto::config::Config& config,
                        const Terrain& terrain,
                        Settings& settings,
                        Diagnostics& diagnostics);

/// Index of the type with this name, or -1.
int find_type(const Settings& settings, const std::string& name);

}  // namespace zoned::config
