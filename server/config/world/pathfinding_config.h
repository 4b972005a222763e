// pathfinding_config: checks that paths can be planned in the zones of a config, and gives the
// settings of their maps.
#pragma once

#include "server/ai/pathfinding/path_settings.h"
#include "server/config/text/diagnostics.h"

#include <string>
#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;
struct ZoneRegion;

/// Replaces the name in ai.pathfinding.waypoints_file by the file's text, so that the config is
/// complete; reports a file that can't be read.
void load_waypoints(proto::config::Config& config, Diagnostics& diagnostics);

/// Where ai.pathfinding is set: reports cells that are too large or too small for a zone, and
/// mistakes in waypoints by their line. `zones` as expanded.
void check_ground_maps(const proto::config::Config& config,
                       const std::vector<ZoneRegion>& zones,
                       Diagnostics& diagnostics);

/// ai.pathfinding, which is set.
ai::PathfindingSettings expand_pathfinding(const proto::config::Config& config);

/// Decides whether paths are planned where ai.pathfinding is not set, and which types need maps.
/// All else of the settings is expanded, and brains are compiled.
void plan_default_paths(Settings& settings);

/// Whether paths are planned, over which maps, and why: one sentence for `zoned check`.
std::string pathfinding_text(const Settings& settings);

/// One sentence for each waypoint of a good config that agents may never reach: in no zone, without
/// edges to it or from it, or not joined with most of the others.
std::vector<std::string> waypoint_warnings(const Settings& settings);

}  // namespace zoned::config
