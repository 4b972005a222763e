// GridQuery: what is asked of a planner on a grid, and what it answers.
#pragma once

#include "server/ai/pathfinding/grid/cost.h"
#include "server/ai/pathfinding/grid/grid_map.h"

#include <cstdint>

namespace zoned::ai::pathfinding {

/// How a path is looked for. All but kWeightedAStar and kHierarchical are exact.
enum class GridMethod : std::uint8_t {
    kDefault,        ///< what suits the map as it is
    kAStar,          ///< cell by cell
    kWeightedAStar,  ///< the path costs at most `weight` times the best
    kJumpPoints,     ///< needs no preparation: exact right after a change
    kSubgoals,       ///< A* among the corners of obstacles; needs an index
    kHubLabels,      ///< distances between corners by looking them up; needs an index with labels
    kHierarchical,   ///< through portals of squares, renewed with each change: nearly the best path
};

enum class PathOutcome : std::uint8_t {
    kFound,        ///< a path from start to goal
    kPartial,      ///< the goal can't be reached; a path to the cell nearest to it that can
    kUnreachable,  ///< start and goal are passable, and no path joins them
    kOffMap,       ///< start or goal is not on the map
    kStartBlocked,
    kGoalBlocked,
    kCutOff,  ///< max_work was not enough; a path to the cell nearest to the goal that was looked
              ///< at (kHierarchical: as far as it was put together, or the start alone)
};

struct GridQuery {
    Cell start;
    Cell goal;
    /// Cells or corners that a search may look at, > 0. Looking up labels costs none.
    std::uint32_t max_work = ~0U;
    /// Of kWeightedAStar, 1 to 16: the path found costs at most so many times the best (Pohl,
    /// "Heuristic search viewed as path finding in a graph", Artificial Intelligence 1, 1970).
    float weight = 1.0F;
    /// Where the goal is blocked or out of reach: go as near to it as can be (kPartial).
    bool nearest = false;
};

struct GridAnswer {
    PathOutcome outcome = PathOutcome::kUnreachable;
    Cost cost = 0;           ///< of the path to the last corner
    double length = 0.0;     ///< the same in cells
    std::uint32_t work = 0;  ///< cells or corners looked at
    /// Labels looked up, and cells around a goal that can't be reached.
    std::uint32_t looked = 0;
};

const char* to_string(PathOutcome outcome);

/// As in the names of rows: "astar", "jump_points".
const char* to_string(GridMethod method);

}  // namespace zoned::ai::pathfinding
