// Lines of sight over cells, and paths pulled straight along them.
#pragma once

#include "server/ai/pathfinding/grid/grid_map.h"

#include <algorithm>
#include <cstdlib>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// Whether all cells that the line from the middle of one cell to that of another touches are
/// passable; where it runs through a corner between four, all four (as steps do, it cuts none).
/// Whole numbers: the same from either end. `looked` grows by the cells looked at.
bool sees(const GridMap& map, Cell from, Cell to, std::uint32_t& looked);

/// Whether sees() looks at a cell between the two: the line touches it, be it by a corner. (The
/// line against the cell's square by separating axes: those of the square, which leave the box
/// around both cells, and the line's normal.)
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

/// Leaves out the corners of a path that are not needed: from each corner that is kept on to the
/// last of those behind it up to which all are seen from there. Never longer than the path.
/// `corners` begins with the start, which stays; so does the goal. Each segment of the path is
/// free.
void pull(const GridMap& map, std::vector<Cell>& corners, std::uint32_t& looked);

}  // namespace zoned::ai::pathfinding
