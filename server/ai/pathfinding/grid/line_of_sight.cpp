#include "server/ai/pathfinding/grid/line_of_sight.h"

namespace zoned::ai::pathfinding {

bool sees(const GridMap& map, Cell from, Cell to, std::uint32_t& looked) {
    const std::int32_t dx = std::abs(to.x - from.x);
    const std::int32_t dy = std::abs(to.y - from.y);
    const auto stride = static_cast<std::int32_t>(map.stride());
    const std::int32_t step_x = to.x > from.x ? 1 : -1;
    const std::int32_t step_y = to.y > from.y ? stride : -stride;
    auto p = static_cast<std::int32_t>(map.place(from));
    const auto open = [&map](std::int32_t at) {
        return map.passable(static_cast<Place>(at));
    };
    if (!open(p)) {
        return false;
    }
    // Which side of its cell the line leaves by: the sign of how far the next border of a column is
    // beyond the next border of a row, along the line (Amanatides and Woo, "A fast voxel traversal
    // algorithm for ray tracing", Eurographics 1987), times 2 dx dy: begins in the middle of both.
    std::int32_t beyond = dy - dx;
    std::int32_t columns = dx;
    std::int32_t rows = dy;
    const auto seen = [&] {
        looked += static_cast<std::uint32_t>(dx + dy - columns - rows) + 1;
    };
    while (columns + rows != 0) {
        if (beyond < 0) {
            p += step_x;
            --columns;
            beyond += 2 * dy;
        } else if (beyond > 0) {
            p += step_y;
            --rows;
            beyond -= 2 * dx;
        } else {
            if (!open(p + step_x) || !open(p + step_y)) {
                seen();
                return false;
            }
            p += step_x + step_y;
            --columns;
            --rows;
            beyond += 2 * dy - 2 * dx;
        }
        if (!open(p)) {
            seen();
            return false;
        }
    }
    seen();
    return true;
}

void pull(const GridMap& map, std::vector<Cell>& corners, std::uint32_t& looked) {
    if (corners.size() < 3) {
        return;
    }
    std::size_t kept = 0;
    for (std::size_t i = 2; i < corners.size(); ++i) {
        if (!sees(map, corners[kept], corners[i], looked)) {
            corners[++kept] = corners[i - 1];
        }
    }
    corners[++kept] = corners.back();
    corners.resize(kept + 1);
}

}  // namespace zoned::ai::pathfinding
