// Line of sight: sees() tests lines over cells, and pull() straightens paths along them.
#pragma once

#include "server/ai/pathfinding/grid/grid_map.h"

#include <algorithm>
#include <cstdlib>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// True if all cells are passable that the line between the middles of two cells touches. Where it
/// runs through a corner between four cells, all four count (as steps do, it cuts none). It uses
/// whole numbers, so the result is the same from either end. `looked` grows by the cells looked at.
bool sees(const GridMap& map, Cell from, Cell to, std::uint32_t& looked);

/// True if sees() looks at a cell between the two: the line touches it, even by a corner. The test
/// uses separating axes: those of the square, which leave the box around both cells, and the line's
/// normal.
inline bool touches(Cell from, Cell to, Cell cell) {
    if (cell.x < std::min(from.x, to.x) || cell.x > std::max(from.x, to.x) ||
        cell.y < std::min(from.y, to.y) || cell.y > std::max(from.y, to.y)) {
        return false;
    }
    const int dx = to.x - from.x;
    const int dy = to.y - from.y;
    const int off = dx * (cell.y - from.y) - dy * (cell.x - from.x);
    return 2 * std::abs(off) <= std::abs(dx) + std::abs(dy);
}

/// Leaves out the corners of a path that are not needed. From each kept corner it goes on to the
/// last corner behind it that is seen, with all corners up to it. The result is never longer than
/// the path. `corners` begins with the start, which stays; so does the goal. Each segment of the
/// path must be free.
void pull(const GridMap& map, std::vector<Cell>& corners, std::uint32_t& looked);

}  // namespace zoned::ai::pathfinding
