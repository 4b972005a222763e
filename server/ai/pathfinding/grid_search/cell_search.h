// Searches over the cells of a map: A* and weighted A*, jump points. Plain and weighted A* are
// reached by no program yet: a setting that chooses the planner of the grid will use them.
#pragma once

#include "server/ai/pathfinding/grid/grid_query.h"
#include "server/ai/pathfinding/grid/open_list.h"
#include "server/ai/pathfinding/grid_search/landmarks.h"

namespace zoned::ai::pathfinding {

/// How a search over places ended.
struct Reached {
    Place last = kNoPlace;  ///< the goal, or what was looked at nearest to it
    bool goal = false;
    std::uint32_t work = 0;  ///< cells looked at
};

/// A* with the octile heuristic (Hart, Nilsson and Raphael, "A formal basis for the heuristic
/// determination of minimum cost paths", 1968); with query.weight > 1 weighted A*, which looks at
/// no cell twice (Likhachev, Gordon and Thrun, "ARA*", 2003, theorem 1: the bound holds all the
/// same). `space` has map.places() nodes; start and goal are passable.
Reached search_cells(const GridMap& map, const GridQuery& query, SearchSpace& space);

/// Jump-point search without cutting corners, 64 cells of a row or column at a time (Harabor and
/// Grastien, "Improving jump point search", ICAPS 2014, section 3; "Online graph pruning for
/// pathfinding on grid maps", AAAI 2011). The best path by query.weight = 1 whatever the weight.
/// A place is reached from another along the diagonal first, then straight. Landmarks are those
/// of the map, or of one that has passable cells besides; a cell may then be looked at twice, for
/// what they tell is rounded.
Reached search_jump_points(const GridMap& map,
                           const GridQuery& query,
                           SearchSpace& space,
                           const Landmarks* landmarks = nullptr);

}  // namespace zoned::ai::pathfinding
