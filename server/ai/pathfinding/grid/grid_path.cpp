#include "server/ai/pathfinding/grid/grid_path.h"

namespace zoned::ai::pathfinding {

namespace {

int sign(int v) {
    return (v > 0) - (v < 0);
}

Cell moved(Cell c, int dx, int dy) {
    return {static_cast<std::uint16_t>(c.x + dx), static_cast<std::uint16_t>(c.y + dy)};
}

/// The cell where the diagonal part of the path from `from` to `to` ends.
Cell turn_of(Cell from, Cell to) {
    const int dx = to.x - from.x;
    const int dy = to.y - from.y;
    const int both = std::min(std::abs(dx), std::abs(dy));
    return moved(from, both * sign(dx), both * sign(dy));
}

}  // namespace

void GridPath::go(Cell to) {
    segment(turn_of(corners_.back(), to));
    segment(to);
}

void GridPath::arrive(Cell to) {
    segment(turn_of(to, corners_.back()));
    segment(to);
}

void GridPath::segment(Cell to) {
    const Cell from = corners_.back();
    const int dx = to.x - from.x;
    const int dy = to.y - from.y;
    if (dx == 0 && dy == 0) {
        return;
    }
    (dx != 0 && dy != 0 ? diagonal_ : straight_) +=
        static_cast<std::uint32_t>(std::max(std::abs(dx), std::abs(dy)));
    if (corners_.size() >= 2) {
        const Cell before = corners_[corners_.size() - 2];
        if (sign(from.x - before.x) == sign(dx) && sign(from.y - before.y) == sign(dy)) {
            corners_.back() = to;
            return;
        }
    }
    corners_.push_back(to);
}

void cells_of(std::span<const Cell> corners, std::vector<Cell>& cells) {
    cells.clear();
    if (corners.empty()) {
        return;
    }
    cells.push_back(corners.front());
    for (std::size_t i = 1; i < corners.size(); ++i) {
        const int dx = sign(corners[i].x - corners[i - 1].x);
        const int dy = sign(corners[i].y - corners[i - 1].y);
        while (cells.back() != corners[i]) {
            cells.push_back(moved(cells.back(), dx, dy));
        }
    }
}

bool free_line(const GridMap& map, Cell from, Cell to) {
    const int dx = sign(to.x - from.x);
    const int dy = sign(to.y - from.y);
    const auto stride = static_cast<std::int64_t>(map.stride());
    const auto passable = [&map](std::int64_t p) {
        return map.passable(static_cast<Place>(p));
    };
    const std::int64_t end = map.place(to);
    std::int64_t turn = map.place(turn_of(from, to));
    std::int64_t p = map.place(from);
    for (; p != turn; p += dx + dy * stride) {
        if (!passable(p + dx) || !passable(p + dy * stride) || !passable(p + dx + dy * stride)) {
            return false;
        }
    }
    const bool along_row = std::abs(to.x - from.x) > std::abs(to.y - from.y);
    const std::int64_t step = along_row ? dx : dy * stride;
    for (; p != end; p += step) {
        if (!passable(p + step)) {
            return false;
        }
    }
    return passable(end);
}

}  // namespace zoned::ai::pathfinding
