// Cell search: searches over the cells of a map by A*, weighted A* and jump points.
// No program uses plain and weighted A* yet; a setting that chooses the planner of the grid will.
#pragma once

#include "server/ai/pathfinding/grid/grid_query.h"
#include "server/ai/pathfinding/grid/open_list.h"
#include "server/ai/pathfinding/grid_search/landmarks.h"

namespace zoned::ai::pathfinding {

/// Reached: the end of a search over places.
struct Reached {
    Place last = kNoPlace;  ///< the goal, or the visited place nearest to it
    bool goal = false;
    std::uint32_t work = 0;  ///< cells looked at
};

/// A* with the octile heuristic; with query.weight > 1 weighted A*, which looks at no cell twice.
/// `space` has map.places() nodes; start and goal are passable. Source: Hart, Nilsson and Raphael,
/// "A formal basis for the heuristic determination of minimum cost paths", 1968. The bound of the
/// weighted form holds by Likhachev, Gordon and Thrun, "ARA*", 2003, theorem 1.
Reached search_cells(const GridMap& map, const GridQuery& query, SearchSpace& space);

/// Jump-point search without cutting corners, 64 cells of a row or column at a time. Sources:
/// Harabor and Grastien, "Improving jump point search", ICAPS 2014, section 3; "Online graph
/// pruning for pathfinding on grid maps", AAAI 2011. Whatever the weight, it finds the best path as
/// for query.weight = 1. A place is reached from another along the diagonal first, then straight.
/// Landmarks must be those of the map, or of one with further passable cells. Then a cell may be
/// looked at twice, because their bounds are rounded.
Reached search_jump_points(const GridMap& map,
                           const GridQuery& query,
                           SearchSpace& space,
                           const Landmarks* landmarks = nullptr);

}  // namespace zoned::ai::pathfinding
