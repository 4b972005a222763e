// Waypoint doors: which waypoints, and edges between them, each door takes away or gives.
#pragma once

#include "server/ai/pathfinding/waypoints/waypoint_graph.h"
#include "shared/motion/apply_input.h"

#include <vector>

namespace zoned::ai::pathfinding {

/// Numbers of waypoints, and behind the last one those of edges.
struct WaypointDoor {
    std::vector<std::uint32_t> taken;  ///< while it is shut: they pass through its box
    std::vector<std::uint32_t> given;  ///< only while it is shut: they lead over it, as a bridge
};

/// One for each of world.doors(). A waypoint is where feet stand. It hangs on a door where the body
/// would touch the door's box; it is carried by the door where its feet are within a step of the
/// box's top, over it. So does an edge of which any place does.
std::vector<WaypointDoor> waypoint_doors(const WaypointGraph& graph,
                                         const motion::StaticGeometry& world,
                                         const motion::CharacterLimits& limits);

}  // namespace zoned::ai::pathfinding
