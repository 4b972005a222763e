#include "server/ai/navigation/cell_search.h"

#include <bit>

namespace zoned::ai::navigation {

namespace {

/// Bits of a map with its lines one below the other: rows, or columns.
struct Lines {
    const std::uint64_t* words;
    std::uint32_t stride;
};

/// 64 bits from `at` on, the first lowest.
std::uint64_t bits_from(const std::uint64_t* words, std::uint32_t at) {
    const std::uint64_t* w = words + (at >> 6U);
    const std::uint32_t shift = at & 63U;
    return shift == 0 ? w[0] : w[0] >> shift | w[1] << (64 - shift);
}

/// 64 bits up to `at`, the last highest.
std::uint64_t bits_to(const std::uint64_t* words, std::uint32_t at) {
    const std::uint64_t* w = words + (at >> 6U);
    const std::uint32_t shift = 63 - (at & 63U);
    return shift == 0 ? w[0] : w[0] << shift | w[-1] >> (64 - shift);
}

/// The next jump point on the line after `at`: the goal, or a cell beside which a row of obstacles
/// has just ended, so that turning there may pay. kNoPlace where an obstacle comes first.
std::uint32_t jump_up(const Lines& l, std::uint32_t at, std::uint32_t goal) {
    for (std::uint32_t first = at + 1;; first += 64) {
        const std::uint64_t a = bits_from(l.words, first - l.stride);
        const std::uint64_t b = bits_from(l.words, first + l.stride);
        const std::uint64_t ends = (a & ~bits_from(l.words, first - l.stride - 1)) |
                                   (b & ~bits_from(l.words, first + l.stride - 1));
        const std::uint64_t blocked = ~bits_from(l.words, first);
        const std::uint64_t stop = ends | blocked;
        const auto steps = static_cast<std::uint32_t>(std::countr_zero(stop));  // 64 for none
        if (goal - first < steps) {
            return goal;
        }
        if (stop != 0) {
            return (blocked >> steps & 1U) != 0 ? kNoPlace : first + steps;
        }
    }
}

/// As jump_up, to smaller numbers.
std::uint32_t jump_down(const Lines& l, std::uint32_t at, std::uint32_t goal) {
    for (std::uint32_t last = at - 1;; last -= 64) {
        const std::uint64_t a = bits_to(l.words, last - l.stride);
        const std::uint64_t b = bits_to(l.words, last + l.stride);
        const std::uint64_t ends = (a & ~bits_to(l.words, last - l.stride + 1)) |
                                   (b & ~bits_to(l.words, last + l.stride + 1));
        const std::uint64_t blocked = ~bits_to(l.words, last);
        const std::uint64_t stop = ends | blocked;
        const auto steps = static_cast<std::uint32_t>(std::countl_zero(stop));
        if (last - goal < steps) {
            return goal;
        }
        if (stop != 0) {
            return (blocked << steps >> 63U) != 0 ? kNoPlace : last - steps;
        }
    }
}

/// Directions in which a cell was entered, as bits: of the step (dx, dy), or (0, 0) of the start.
constexpr std::uint32_t direction_bit(int dx, int dy) {
    return 1U << static_cast<std::uint32_t>(3 * (dy + 1) + dx + 1);
}

constexpr std::uint32_t kNewShift = 16;  // directions that were not looked at yet lie above

/// Ways of the same cost may enter a jump point in several directions, and which of them go on may
/// differ: all are remembered and followed, so that exactness hangs on no order of ties.
template <class Heuristic>
class JumpSearch {
  public:
    JumpSearch(const GridMap& map,
               const Query& query,
               const Heuristic& heuristic,
               SearchSpace& space)
        : map_(map),
          heuristic_(heuristic),
          space_(space),
          rows_{map.row_bits().data(), map.stride()},
          columns_{map.column_bits().data(), map.column_stride()},
          goal_(query.goal),
          goal_in_rows_(map.place(query.goal)),
          goal_in_columns_(map.column_place(query.goal)),
          most_(query.max_work) {}

    Reached run(Cell start) {
        space_.begin();
        const Place first = map_.place(start);
        space_.reach(first, 0, first, direction_bit(0, 0) << kNewShift);
        space_.open.push(first, 0);
        Cost nearest = kNoCost;
        while (!space_.open.empty() && reached_.work != most_) {
            at_ = space_.open.pop();
            cell_ = map_.cell(at_);
            cost_ = space_.cost(at_);
            ++reached_.work;
            const Cost h = octile(goal_.x - cell_.x, goal_.y - cell_.y);
            if (h < nearest) {
                nearest = h;
                reached_.last = at_;
            }
            if (at_ == goal_in_rows_) {
                reached_.goal = true;
                break;
            }
            expand();
        }
        return reached_;
    }

  private:
    /// In all directions in which the cell was entered since it was last looked at.
    void expand() {
        std::uint32_t& tag = space_.tag(at_);
        const std::uint32_t fresh = tag >> kNewShift;
        tag = (tag | fresh) & ((1U << kNewShift) - 1);
        for (std::uint32_t rest = fresh; rest != 0; rest &= rest - 1) {
            const int bit = std::countr_zero(rest);
            expand(bit % 3 - 1, bit / 3 - 1);
        }
    }

    /// Only where a best way may go on that came this way.
    void expand(int dx, int dy) {
        if (dx == 0 && dy == 0) {
            for (const int s : {-1, 1}) {
                along_row(s);
                along_column(s);
                diagonal(s, -1);
                diagonal(s, 1);
            }
            return;
        }
        if (dx != 0) {
            along_row(dx);
        }
        if (dy != 0) {
            along_column(dy);
        }
        if (dx != 0 && dy != 0) {
            diagonal(dx, dy);
            return;
        }
        const auto stride = static_cast<int>(map_.stride());
        const int side = dx != 0 ? stride : 1;
        const int ahead = dx != 0 ? dx : dy * stride;
        for (const int s : {-1, 1}) {
            if (open(s * side) && !open(s * side - ahead)) {
                dx != 0 ? along_column(s) : along_row(s);
                dx != 0 ? diagonal(dx, s) : diagonal(s, dy);
            }
        }
    }

    [[nodiscard]] bool open(int offset) const {
        return map_.passable(static_cast<Place>(static_cast<int>(at_) + offset));
    }

    void along_row(int dx) {
        const Place to =
            dx > 0 ? jump_up(rows_, at_, goal_in_rows_) : jump_down(rows_, at_, goal_in_rows_);
        if (to != kNoPlace) {
            const int steps = static_cast<int>(to) - static_cast<int>(at_);
            relax(to, dx, 0, std::abs(steps));
        }
    }

    void along_column(int dy) {
        const std::uint32_t at = map_.column_place(cell_);
        const std::uint32_t to = dy > 0 ? jump_up(columns_, at, goal_in_columns_)
                                        : jump_down(columns_, at, goal_in_columns_);
        if (to != kNoPlace) {
            const int steps = static_cast<int>(to) - static_cast<int>(at);
            const int down = steps * static_cast<int>(map_.stride());
            relax(static_cast<Place>(static_cast<int>(at_) + down), 0, dy, std::abs(steps));
        }
    }

    /// To the first cell from which a row or a column leads on to a jump point.
    void diagonal(int dx, int dy) {
        const int down = dy * static_cast<int>(map_.stride());
        const int column_step = dx * static_cast<int>(map_.column_stride()) + dy;
        auto p = static_cast<int>(at_);
        auto q = static_cast<int>(map_.column_place(cell_));
        const auto passable = [this](int place) {
            return map_.passable(static_cast<Place>(place));
        };
        for (int steps = 1;; ++steps) {
            if (!passable(p + dx) || !passable(p + down) || !passable(p + dx + down)) {
                return;
            }
            p += dx + down;
            q += column_step;
            const auto row = static_cast<std::uint32_t>(p);
            const auto column = static_cast<std::uint32_t>(q);
            if (row == goal_in_rows_ ||
                (dx > 0 ? jump_up(rows_, row, goal_in_rows_)
                        : jump_down(rows_, row, goal_in_rows_)) != kNoPlace ||
                (dy > 0 ? jump_up(columns_, column, goal_in_columns_)
                        : jump_down(columns_, column, goal_in_columns_)) != kNoPlace) {
                relax(row, dx, dy, steps);
                return;
            }
        }
    }

    /// `to` lies so many steps of (dx, dy) away.
    void relax(Place to, int dx, int dy, int steps) {
        const Cost step = dx != 0 && dy != 0 ? kDiagonal : kStraight;
        const Cost g = cost_ + step * static_cast<Cost>(steps);
        const Cost known = space_.cost(to);
        const std::uint32_t direction = direction_bit(dx, dy);
        if (g < known) {
            space_.reach(to, g, at_, direction << kNewShift);
        } else if (g > known || ((space_.tag(to) | space_.tag(to) >> kNewShift) & direction) != 0) {
            return;
        } else {
            space_.tag(to) |= direction << kNewShift;
        }
        const Cost h = std::max(
            octile(goal_.x - cell_.x - steps * dx, goal_.y - cell_.y - steps * dy), heuristic_(to));
        space_.open.push(to, (std::uint64_t{g} + h) << 32U | h);
    }

    const GridMap& map_;
    const Heuristic& heuristic_;
    SearchSpace& space_;
    Lines rows_;
    Lines columns_;
    Cell goal_;
    std::uint32_t goal_in_rows_;
    std::uint32_t goal_in_columns_;
    std::uint32_t most_;
    Place at_ = kNoPlace;  // the cell being looked at
    Cell cell_;
    Cost cost_ = 0;
    Reached reached_;
};

}  // namespace

Reached search_jump_points(const GridMap& map,
                           const Query& query,
                           SearchSpace& space,
                           const Landmarks* landmarks) {
    if (landmarks == nullptr) {
        const auto nothing = [](Place /*from*/) {
            return Cost{0};
        };
        return JumpSearch(map, query, nothing, space).run(query.start);
    }
    const Landmarks::Towards towards(*landmarks, map.place(query.goal));
    const auto least = [&towards](Place from) {
        return towards.least(from);
    };
    return JumpSearch(map, query, least, space).run(query.start);
}

}  // namespace zoned::ai::navigation
