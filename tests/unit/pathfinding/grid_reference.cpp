// build: computes
#include "tests/unit/pathfinding/grid_reference.h"

#include "shared/core/rng.h"

#include <cmath>
#include <numbers>
#include <queue>

namespace zoned::ai::pathfinding {

namespace {

Cell cell_at(int x, int y) {
    return {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
}

bool may_step(const GridMap& map, Cell from, int dx, int dy) {
    const auto free = [&map](int x, int y) {
        return x >= 0 && y >= 0 && map.passable(cell_at(x, y));
    };
    return free(from.x + dx, from.y) && free(from.x, from.y + dy) && free(from.x + dx, from.y + dy);
}

std::string text_of(Cell c) {
    return "(" + std::to_string(c.x) + ", " + std::to_string(c.y) + ")";
}

}  // namespace

GridMap map_of(std::initializer_list<std::string_view> rows) {
    GridMap map(static_cast<int>(rows.begin()->size()), static_cast<int>(rows.size()));
    int y = 0;
    for (const std::string_view row : rows) {
        for (int x = 0; x < map.width(); ++x) {
            map.set_passable(cell_at(x, y), row[static_cast<std::size_t>(x)] != '#');
        }
        ++y;
    }
    return map;
}

GridMap random_map(int width, int height, float blocked, std::uint64_t seed) {
    GridMap map(width, height);
    core::Rng rng(seed);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            map.set_passable(cell_at(x, y), rng.range(0.0F, 1.0F) >= blocked);
        }
    }
    return map;
}

GridMap rooms_map(int width, int height, int room, std::uint64_t seed) {
    GridMap map(width, height);
    core::Rng rng(seed);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            map.set_passable(cell_at(x, y), x % room != 0 && y % room != 0);
        }
    }
    const auto within = [&rng, room](int n) {
        return n * room + 1 + static_cast<int>(rng.below(static_cast<std::uint32_t>(room - 1)));
    };
    for (int v = 0; v * room < height; ++v) {
        for (int u = 0; u * room < width; ++u) {
            const Cell left = cell_at(u * room, within(v));
            const Cell top = cell_at(within(u), v * room);
            if (u > 0 && map.contains(left) && rng.below(4) != 0) {
                map.set_passable(left, true);
            }
            if (v > 0 && map.contains(top) && rng.below(4) != 0) {
                map.set_passable(top, true);
            }
        }
    }
    return map;
}

std::vector<double> all_lengths(const GridMap& map, Cell start) {
    const auto index = [&map](Cell c) {
        return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(map.width()) + c.x;
    };
    std::vector<double> length(
        static_cast<std::size_t>(map.width()) * static_cast<std::size_t>(map.height()), kNoPath);
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    length[index(start)] = 0.0;
    open.emplace(0.0, map.place(start));
    while (!open.empty()) {
        const auto [known, place] = open.top();
        open.pop();
        const Cell c = map.cell(place);
        if (known > length[index(c)]) {
            continue;
        }
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                if ((dx == 0 && dy == 0) || !may_step(map, c, dx, dy)) {
                    continue;
                }
                const Cell to = cell_at(c.x + dx, c.y + dy);
                const double next = known + (dx != 0 && dy != 0 ? std::numbers::sqrt2 : 1.0);
                if (next < length[index(to)]) {
                    length[index(to)] = next;
                    open.emplace(next, map.place(to));
                }
            }
        }
    }
    return length;
}

std::string wrong_with(const GridMap& map,
                       Cell start,
                       Cell goal,
                       double length,
                       std::span<const Cell> corners) {
    if (corners.empty() || corners.front() != start || corners.back() != goal) {
        return "it does not lead from start to goal";
    }
    double sum = 0.0;
    for (std::size_t i = 1; i < corners.size(); ++i) {
        const int dx = corners[i].x - corners[i - 1].x;
        const int dy = corners[i].y - corners[i - 1].y;
        if ((dx == 0 && dy == 0) || (dx != 0 && dy != 0 && std::abs(dx) != std::abs(dy))) {
            return "from " + text_of(corners[i - 1]) + " to " + text_of(corners[i]) +
                   " is no straight line";
        }
        Cell c = corners[i - 1];
        while (c != corners[i]) {
            const int sx = (dx > 0) - (dx < 0);
            const int sy = (dy > 0) - (dy < 0);
            if (!map.passable(c) || !may_step(map, c, sx, sy)) {
                return "no step leads on from " + text_of(c);
            }
            c = cell_at(c.x + sx, c.y + sy);
            sum += sx != 0 && sy != 0 ? std::numbers::sqrt2 : 1.0;
        }
    }
    return std::abs(sum - length) > kRounding
               ? "it is " + std::to_string(sum) + " long, not " + std::to_string(length)
               : "";
}

}  // namespace zoned::ai::pathfinding
