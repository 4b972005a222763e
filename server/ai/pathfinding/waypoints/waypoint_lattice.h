// Waypoint lattice: waypoints at regular distances wherever one can stand.
#pragma once

#include "server/ai/pathfinding/grid/ground_map.h"
#include "server/ai/pathfinding/waypoints/waypoint_graph.h"

namespace zoned::ai::pathfinding {

/// A waypoint in the middle of each passable cell, with edges to its eight neighbours that a step
/// leads to (diagonally only where both cells beside it are passable), as long as they are. Fails
/// where the graph would be too large.
core::Result<WaypointGraph> waypoint_lattice(const GroundMap& ground);

}  // namespace zoned::ai::pathfinding
