// Ground maps: whether paths can be planned in the zones of a config, and on what.
#pragma once

#include "server/ai/pathfinding/path_service.h"
#include "server/config/text/diagnostics.h"

#include <string>
#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;
struct ZoneRegion;

/// Puts the text of ai.pathfinding.waypoints_file in the place of its name, so that the config
/// holds all of it; reports a file that can't be read.
void load_waypoints(proto::config::Config& config, Diagnostics& diagnostics);

/// Where ai.pathfinding is set: reports cells that are too large or too small for a zone, and what
/// is wrong with waypoints, by their line. `zones` as expanded.
void check_ground_maps(const proto::config::Config& config,
                       const std::vector<ZoneRegion>& zones,
                       Diagnostics& diagnostics);

/// ai.pathfinding, which is set.
ai::PathfindingSettings expand_pathfinding(const proto::config::Config& config);

/// One sentence each about waypoints of a good config that nobody may get to: in no zone, without
/// edges that lead there or away, or not joined with most of the others.
std::vector<std::string> waypoint_warnings(const Settings& settings);

}  // namespace zoned::config
