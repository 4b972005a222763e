// Waypoint doors: the waypoints and edges that each door takes away or gives.
#pragma once

#include "server/ai/pathfinding/waypoints/waypoint_graph.h"
#include "shared/motion/apply_input.h"

#include <vector>

namespace zoned::ai::pathfinding {

/// Numbers of waypoints; edges are numbered behind the last waypoint.
struct WaypointDoor {
    std::vector<std::uint32_t> taken;  ///< taken while it is shut: they pass through its box
    std::vector<std::uint32_t> given;  ///< given only while it is shut: they lead over it, as over
                                       ///< a bridge
};

/// Returns a WaypointDoor for each of world.doors(). A waypoint is where feet stand. It is taken by
/// a door where the body would touch the door's box. It is given by the door where its feet stand
/// over the box, within a step of its top. An edge is taken or given if any place on it is.
std::vector<WaypointDoor> waypoint_doors(const WaypointGraph& graph,
                                         const motion::StaticGeometry& world,
                                         const motion::CharacterLimits& limits);

}  // namespace zoned::ai::pathfinding
