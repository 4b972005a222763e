// Waypoint lattice: makes a graph of waypoints at regular distances wherever one can stand.
#pragma once

#include "server/ai/pathfinding/grid/ground_map.h"
#include "server/ai/pathfinding/waypoints/waypoint_graph.h"

namespace zoned::ai::pathfinding {

/// Puts a waypoint in the middle of each passable cell. Its edges lead to the eight neighbours that
/// a step can reach, and weigh their lengths. A diagonal edge needs both cells beside it passable.
/// Fails where the graph would be too large.
core::Result<WaypointGraph> waypoint_lattice(const GroundMap& ground);

}  // namespace zoned::ai::pathfinding
