#include "server/ai/pathfinding/grid_search/cell_search.h"

#include <cmath>

namespace zoned::ai::pathfinding {

namespace {

/// Weights are multiples of this: keys are whole numbers.
constexpr std::uint64_t kWeightUnit = 256;

class CellSearch {
  public:
    CellSearch(const GridMap& map, const GridQuery& query, SearchSpace& space)
        : map_(map),
          space_(space),
          goal_(query.goal),
          goal_place_(map.place(query.goal)),
          most_(query.max_work),
          weight_(static_cast<std::uint64_t>(
              std::lround(query.weight * static_cast<float>(kWeightUnit)))) {}

    Reached run(Cell start) {
        space_.begin();
        const Place first = map_.place(start);
        space_.reach(first, 0, first);
        space_.open.push(first, 0);
        Cost nearest = kNoCost;
        while (!space_.open.empty()) {
            if (reached_.work == most_) {
                return reached_;
            }
            const Place p = space_.open.pop();
            ++reached_.work;
            const Cell c = map_.cell(p);
            const Cost h = octile(goal_.x - c.x, goal_.y - c.y);
            if (h < nearest) {
                nearest = h;
                reached_.last = p;
            }
            if (p == goal_place_) {
                reached_.goal = true;
                return reached_;
            }
            expand(p, c);
        }
        return reached_;
    }

  private:
    void expand(Place p, Cell c) {
        const Place up = p - map_.stride();
        const Place down = p + map_.stride();
        const Cost g = space_.cost(p);
        const bool n = map_.passable(up);
        const bool s = map_.passable(down);
        const bool w = map_.passable(p - 1);
        const bool e = map_.passable(p + 1);
        const auto try_step = [&](bool open, Place to, int dx, int dy, Cost step) {
            if (open) {
                relax(p, to, g + step, octile(goal_.x - c.x - dx, goal_.y - c.y - dy));
            }
        };
        try_step(n, up, 0, -1, kStraight);
        try_step(s, down, 0, 1, kStraight);
        try_step(w, p - 1, -1, 0, kStraight);
        try_step(e, p + 1, 1, 0, kStraight);
        try_step(n && w && map_.passable(up - 1), up - 1, -1, -1, kDiagonal);
        try_step(n && e && map_.passable(up + 1), up + 1, 1, -1, kDiagonal);
        try_step(s && w && map_.passable(down - 1), down - 1, -1, 1, kDiagonal);
        try_step(s && e && map_.passable(down + 1), down + 1, 1, 1, kDiagonal);
    }

    void relax(Place from, Place to, Cost g, Cost h) {
        const Cost known = space_.cost(to);
        if (g >= known || (known != kNoCost && !space_.open.contains(to))) {
            return;  // no better, or expanded already
        }
        space_.reach(to, g, from);
        // 44 bits of cost; among equals the one nearer to the goal is first.
        space_.open.push(to, (g * kWeightUnit + h * weight_) << 20U | h >> 12U);
    }

    const GridMap& map_;
    SearchSpace& space_;
    Cell goal_;
    Place goal_place_;
    std::uint32_t most_;
    std::uint64_t weight_;
    Reached reached_;
};

}  // namespace

Reached search_cells(const GridMap& map, const GridQuery& query, SearchSpace& space) {
    return CellSearch(map, query, space).run(query.start);
}

}  // namespace zoned::ai::pathfinding
