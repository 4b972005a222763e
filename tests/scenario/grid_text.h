// GridText: text of the Moving AI benchmark, with maps, scenarios, and maps that change.
#pragma once

#include "server/ai/pathfinding/grid/grid_map.h"
#include "shared/core/result.h"

#include <string>
#include <string_view>
#include <vector>

namespace zoned::scenario {

using ai::pathfinding::Cell;
using ai::pathfinding::GridMap;

/// `.map` (N. Sturtevant, "Benchmarks for Grid-Based Pathfinding", 2012, section III): `type
/// octile`, `height H`, `width W`, `map`, then H rows of W characters. `.`, `G` and `S` are
/// passable, `@`, `O`, `T` and `W` are not. Lines end in LF or CRLF. Errors name the line. At most
/// kMostPassable (cost.h) cells are passable.
core::Result<GridMap> parse_grid_map(std::string_view text);

/// A query whose answer is known.
struct GridInstance {
    Cell start;
    Cell goal;
    double length = 0.0;  ///< of a best path, cells
    int line = 0;
};

/// `.scen`: `version 1`, then lines of bucket, map, width, height, start x y, goal x y, length,
/// between tabs or spaces. Errors name the line; a start or goal off the map of the line's own
/// width and height is an error.
core::Result<std::vector<GridInstance>> parse_grid_scenario(std::string_view text);

/// A rectangle of cells that is laid over a map.
struct GridPatch {
    int width = 0;
    int height = 0;
    std::vector<bool> passable;  ///< row by row
};

/// `.patch`: `type patch`, `patches N`, then `patch I`, `height`, `width`, `map`, rows; in order.
core::Result<std::vector<GridPatch>> parse_grid_patches(std::string_view text);

/// One line of a scenario of a map that changes.
struct GridEvent {
    bool query = false;     ///< else a patch is laid
    GridInstance instance;  ///< of a query
    int patch = 0;          ///< which, of a patch
    int x = 0;              ///< of the patch's left column
    int y = 0;              ///< of its top row
};

/// `.scen`, version 2: after the line `commands`, `Q bucket sx sy gx gy length` and `P bucket patch
/// x y`.
core::Result<std::vector<GridEvent>> parse_grid_events(std::string_view text);

}  // namespace zoned::scenario
