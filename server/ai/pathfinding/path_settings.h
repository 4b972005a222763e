// PathfindingSettings: the kind of map that the paths of a zone lead over, and its limits.
#pragma once

#include "server/ai/pathfinding/flow_fields/crowd_path_settings.h"
#include "server/ai/pathfinding/grid/grid_query.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace zoned::ai {

namespace pathfinding {
class WaypointGraph;
}

/// PathMapKind: the kind of map that paths lead over.
enum class PathMapKind : std::uint8_t {
    kGrid,           ///< cells, one floor: exact in where one can walk, and the fastest
    kNavmesh,        ///< polygons by Recast, any number of floors
    kWaypointGraph,  ///< waypoints with weighted edges: hand-placed or regular
};

struct PathfindingSettings {
    float cell_m = 0.0F;  ///< cell size of the maps; 0: no paths are planned. kWaypointGraph:
                          ///< distance of waypoints
    /// Work in a tick and zone, in units of about 2 ns; shared evenly among the sizes of
    /// characters.
    std::uint64_t work_per_tick = 1'000'000;
    PathMapKind map = PathMapKind::kGrid;
    pathfinding::GridSearch search{};                          ///< kGrid
    float cell_height_m = 0.05F;                               ///< kNavmesh: one step of height
    std::optional<pathfinding::CrowdPathSettings> crowding{};  ///< kGrid; none: paths ignore crowds
    /// kWaypointGraph: the waypoints of the world, in its coordinates; null: regular waypoints
    /// wherever one can stand.
    std::shared_ptr<const pathfinding::WaypointGraph> waypoints{};
    /// By type of entity: 1 where its agents go to places, and need a map. Empty: all do.
    std::vector<std::uint8_t> travels{};
};

}  // namespace zoned::ai
