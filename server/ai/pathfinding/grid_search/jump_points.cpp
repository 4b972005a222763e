#include "server/ai/pathfinding/grid_search/cell_search.h"

#include <algorithm>
#include <bit>

namespace zoned::ai::pathfinding {

namespace {

/// Bits of a map with its lines one below the other: rows, or columns.
struct Lines {
    const std::uint64_t* words;
    std::uint32_t stride;
};

/// 64 bits from the `shift`-th of a word on, the first lowest.
std::uint64_t bits_from(const std::uint64_t* word, std::uint32_t shift) {
    return word[0] >> shift | word[1] << 1U << (63 - shift);
}

/// 64 bits up to the (63 - `shift`)-th of a word, the last highest.
std::uint64_t bits_to(const std::uint64_t* word, std::uint32_t shift) {
    return word[0] << shift | word[-1] >> 1U >> (63 - shift);
}

/// Cells that are tested together: the cells behind the first one come with it.
constexpr std::uint32_t kSeen = 63;

/// The next jump point on the line after `at`: the goal, or a cell beside which a row of obstacles
/// has just ended, so that turning there may pay. kNoPlace where an obstacle comes first.
std::uint32_t jump_up(const Lines& l, std::uint32_t at, std::uint32_t goal) {
    const std::uint32_t line = l.stride >> 6U;
    for (;; at += kSeen) {
        const std::uint64_t* const word = l.words + (at >> 6U);
        const std::uint32_t shift = at & 63U;
        const std::uint64_t a = bits_from(word - line, shift);
        const std::uint64_t b = bits_from(word + line, shift);
        const std::uint64_t ends = (a >> 1U & ~a) | (b >> 1U & ~b);
        const std::uint64_t blocked = ~bits_from(word, shift) >> 1U;
        const std::uint64_t stop = ends | blocked;
        const auto steps = static_cast<std::uint32_t>(std::countr_zero(stop));  // 64 for none
        if (goal - at - 1 < std::min(steps, kSeen)) {
            return goal;
        }
        if (stop != 0) {
            return (blocked >> steps & 1U) != 0 ? kNoPlace : at + 1 + steps;
        }
    }
}

/// As jump_up, to smaller numbers.
std::uint32_t jump_down(const Lines& l, std::uint32_t at, std::uint32_t goal) {
    const std::uint32_t line = l.stride >> 6U;
    for (;; at -= kSeen) {
        const std::uint64_t* const word = l.words + (at >> 6U);
        const std::uint32_t shift = 63 - (at & 63U);
        const std::uint64_t a = bits_to(word - line, shift);
        const std::uint64_t b = bits_to(word + line, shift);
        const std::uint64_t ends = (a << 1U & ~a) | (b << 1U & ~b);
        const std::uint64_t blocked = ~bits_to(word, shift) << 1U;
        const std::uint64_t stop = ends | blocked;
        const auto steps = static_cast<std::uint32_t>(std::countl_zero(stop));
        if (at - 1 - goal < std::min(steps, kSeen)) {
            return goal;
        }
        if (stop != 0) {
            return (blocked << steps >> 63U) != 0 ? kNoPlace : at - 1 - steps;
        }
    }
}

/// Directions in which a cell was entered, as bits: of the step (dx, dy), or (0, 0) of the start.
constexpr std::uint32_t direction_bit(int dx, int dy) {
    return 1U << static_cast<std::uint32_t>(3 * (dy + 1) + dx + 1);
}

constexpr std::uint32_t kNewShift = 16;  // directions that were not expanded yet lie above

/// Paths of the same cost may enter a jump point in several directions, and may go on differently.
/// All directions are stored and followed, so the result is exact for any order of ties.
template <class Heuristic, bool kLooksAhead>
class JumpSearch {
  public:
    JumpSearch(const GridMap& map,
               const GridQuery& query,
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
    /// Expands all directions in which the cell was entered since it was last expanded.
    void expand() {
        std::uint32_t& tag = space_.tag(at_);
        const std::uint32_t fresh = tag >> kNewShift;
        tag = (tag | fresh) & ((1U << kNewShift) - 1);
        for (std::uint32_t rest = fresh; rest != 0; rest &= rest - 1) {
            const int bit = std::countr_zero(rest);
            expand(bit % 3 - 1, bit / 3 - 1);
        }
    }

    /// Expands only where a best path from this direction may go on.
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

    /// From: the cell being expanded, or one on a diagonal from there.
    struct From {
        Place place;
        std::uint32_t column_place;
        Cell cell;
        Cost cost;
    };

    [[nodiscard]] From here() const { return {at_, map_.column_place(cell_), cell_, cost_}; }

    void along_row(int dx) { along_row(here(), dx); }

    void along_column(int dy) { along_column(here(), dy); }

    [[nodiscard]] Place next_in_row(const From& from, int dx) const {
        return dx > 0 ? jump_up(rows_, from.place, goal_in_rows_)
                      : jump_down(rows_, from.place, goal_in_rows_);
    }

    /// By columns.
    [[nodiscard]] std::uint32_t next_in_column(const From& from, int dy) const {
        return dy > 0 ? jump_up(columns_, from.column_place, goal_in_columns_)
                      : jump_down(columns_, from.column_place, goal_in_columns_);
    }

    /// True if there is a jump point.
    bool along_row(const From& from, int dx) {
        const Place to = next_in_row(from, dx);
        if (to == kNoPlace) {
            return false;
        }
        const int steps = static_cast<int>(to) - static_cast<int>(from.place);
        const Cost cost = from.cost + kStraight * static_cast<Cost>(std::abs(steps));
        relax(to, from.cell.x + steps, from.cell.y, direction_bit(dx, 0), cost);
        return true;
    }

    bool along_column(const From& from, int dy) {
        const std::uint32_t to = next_in_column(from, dy);
        if (to == kNoPlace) {
            return false;
        }
        const int steps = static_cast<int>(to) - static_cast<int>(from.column_place);
        const int down = steps * static_cast<int>(map_.stride());
        const Cost cost = from.cost + kStraight * static_cast<Cost>(std::abs(steps));
        relax(static_cast<Place>(static_cast<int>(from.place) + down),
              from.cell.x,
              from.cell.y + steps,
              direction_bit(0, dy),
              cost);
        return true;
    }

    /// Finds the jump points that rows and columns lead to from the cells of a diagonal. These
    /// cells are not expanded themselves (pruned as in Harabor and Grastien, "Improving jump point
    /// search", ICAPS 2014). The exception is the kAhead-th from the first with such a point on. It
    /// goes on if its turn comes, because diagonals may be long and mostly lead away. Without
    /// landmarks cells cost little to expand, and the first one goes on.
    void diagonal(int dx, int dy) {
        const int down = dy * static_cast<int>(map_.stride());
        const int column_step = dx * static_cast<int>(map_.column_stride()) + dy;
        From on = here();
        int passed = 0;
        const auto open = [this, &on](int offset) {
            return map_.passable(static_cast<Place>(static_cast<int>(on.place) + offset));
        };
        while (open(dx) && open(down) && open(dx + down)) {
            on.place = static_cast<Place>(static_cast<int>(on.place) + dx + down);
            on.column_place =
                static_cast<std::uint32_t>(static_cast<int>(on.column_place) + column_step);
            on.cell = {static_cast<std::uint16_t>(on.cell.x + dx),
                       static_cast<std::uint16_t>(on.cell.y + dy)};
            on.cost += kDiagonal;
            bool stop = on.place == goal_in_rows_;
            if (!stop && !kLooksAhead) {
                stop = next_in_row(on, dx) != kNoPlace || next_in_column(on, dy) != kNoPlace;
            } else if (!stop) {
                const bool row = along_row(on, dx);
                const bool column = along_column(on, dy);
                passed += passed != 0 || row || column ? 1 : 0;
                stop = passed == kAhead;
            }
            if (stop) {
                relax(on.place, on.cell.x, on.cell.y, direction_bit(dx, dy), on.cost);
                return;
            }
        }
    }

    /// `to` at (x, y) is reached for `g`, last in that direction.
    void relax(Place to, int x, int y, std::uint32_t direction, Cost g) {
        const Cost known = space_.cost(to);
        if (g < known) {
            space_.reach(to, g, at_, direction << kNewShift);
        } else if (g > known || ((space_.tag(to) | space_.tag(to) >> kNewShift) & direction) != 0) {
            return;
        } else {
            space_.tag(to) |= direction << kNewShift;
        }
        const Cost h = std::max(octile(goal_.x - x, goal_.y - y), heuristic_(to));
        space_.open.push(to, (std::uint64_t{g} + h) << 32U | h);
    }

    static constexpr int kAhead = 4;

    const GridMap& map_;
    const Heuristic& heuristic_;
    SearchSpace& space_;
    Lines rows_;
    Lines columns_;
    Cell goal_;
    std::uint32_t goal_in_rows_;
    std::uint32_t goal_in_columns_;
    std::uint32_t most_;
    Place at_ = kNoPlace;  // the cell being expanded
    Cell cell_;
    Cost cost_ = 0;
    Reached reached_;
};

}  // namespace

Reached search_jump_points(const GridMap& map,
                           const GridQuery& query,
                           SearchSpace& space,
                           const Landmarks* landmarks) {
    if (landmarks == nullptr) {
        const auto nothing = [](Place /*from*/) {
            return Cost{0};
        };
        return JumpSearch<decltype(nothing), false>(map, query, nothing, space).run(query.start);
    }
    const Landmarks::Towards towards(*landmarks, map.place(query.goal));
    const auto least = [&towards](Place from) {
        return towards.least(from);
    };
    return JumpSearch<decltype(least), true>(map, query, least, space).run(query.start);
}

}  // namespace zoned::ai::pathfinding
