// GridQuery: a query to a planner on a grid, and GridAnswer, its answer.
#pragma once

#include "server/ai/pathfinding/grid/cost.h"
#include "server/ai/pathfinding/grid/grid_map.h"

#include <cstdint>

namespace zoned::ai::pathfinding {

/// GridMethod: the search method. All but kWeightedAStar are exact.
enum class GridMethod : std::uint8_t {
    kDefault,        ///< the method that suits the map as it is
    kAStar,          ///< cell by cell
    kWeightedAStar,  ///< the path costs at most `weight` times the best
    kJumpPoints,     ///< needs no preparation: exact right after a change
    kSubgoals,       ///< A* among the corners of obstacles; needs an index
    kHubLabels,      ///< looks up distances between corners; needs an index with labels
};

/// GridSearch: the search that a planner uses where a query names none.
struct GridSearch {
    GridMethod method = GridMethod::kDefault;
    float weight = 1.0F;  ///< of kWeightedAStar, 1 to 16
};

enum class PathOutcome : std::uint8_t {
    kFound,        ///< a path from start to goal
    kPartial,      ///< the goal cannot be reached; a path to the reachable cell nearest to it
    kUnreachable,  ///< start and goal are passable, and no path joins them
    kOffMap,       ///< start or goal is not on the map
    kStartBlocked,
    kGoalBlocked,
    kCutOff,  ///< max_work was not enough. The path leads to the visited cell nearest to the goal.
};

struct GridQuery {
    Cell start;
    Cell goal;
    /// The most cells or corners that a search may look at, > 0. Looking up labels is free.
    std::uint32_t max_work = ~0U;
    /// For kWeightedAStar, 1 to 16: the path costs at most so many times the best. Source: Pohl,
    /// "Heuristic search viewed as path finding in a graph", Artificial Intelligence 1, 1970.
    float weight = 1.0F;
    /// Where the goal is blocked or out of reach, go as near to it as possible (kPartial).
    bool nearest = false;
};

struct GridAnswer {
    PathOutcome outcome = PathOutcome::kUnreachable;
    Cost cost = 0;           ///< of the path to the last corner
    double length = 0.0;     ///< the same in cells
    std::uint32_t work = 0;  ///< cells or corners looked at
    /// Labels looked up, and cells looked at around a goal that cannot be reached.
    std::uint32_t looked = 0;
};

const char* to_string(PathOutcome outcome);

/// The name in configuration rows: "astar", "jump_points".
const char* to_string(GridMethod method);

}  // namespace zoned::ai::pathfinding
