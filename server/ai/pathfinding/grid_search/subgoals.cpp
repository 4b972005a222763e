#include "server/ai/pathfinding/grid_search/subgoals.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

/// Four directions along rows and columns, then the diagonals between each and the next.
constexpr int kCompass = 8;
constexpr std::array<int, kCompass> kCompassX{1, 0, -1, 0, 1, -1, -1, 1};
constexpr std::array<int, kCompass> kCompassY{0, 1, 0, -1, 1, 1, -1, -1};

/// Clearances: the free distance from each place, up to a blocked cell or a subgoal.
class Clearances {
  public:
    Clearances(const GridMap& map, std::span<const Subgoal> numbers)
        : map_(map),
          numbers_(numbers),
          steps_(std::make_unique_for_overwrite<Steps[]>(map.places())) {
        const auto stride = static_cast<std::int32_t>(map.stride());
        for (std::size_t d = 0; d < kCompass; ++d) {
            offset_[d] = kCompassX[d] + kCompassY[d] * stride;
        }
    }

    /// The cells ahead of a place are known before the place itself. First come all rows downwards,
    /// and in them cells to the right. Then come all rows upwards, and in them cells to the left.
    /// Memory is first touched row by row, too.
    void take_row(int y, bool downwards) {
        for (int i = 0; i < map_.width(); ++i) {
            if (downwards) {
                take(at(i, y), {2, 3, 6, 7});
            } else {
                take(at(map_.width() - 1 - i, y), {0, 1, 4, 5});
            }
        }
    }

    /// Steps that can be taken; the last may end on a subgoal.
    [[nodiscard]] int steps(Place p, std::size_t direction) const { return steps_[p][direction]; }

    [[nodiscard]] bool subgoal(Place p) const { return numbers_[p] != kNoSubgoal; }

    [[nodiscard]] Place moved(Place p, std::size_t direction, int steps) const {
        return static_cast<Place>(static_cast<std::int32_t>(p) + steps * offset_[direction]);
    }

  private:
    [[nodiscard]] Place at(int x, int y) const {
        return map_.place({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
    }

    using Steps = std::array<std::uint16_t, kCompass>;

    void take(Place p, const std::array<std::size_t, 4>& directions) {
        for (const std::size_t d : directions) {
            steps_[p][d] = 0;
        }
        if (!map_.passable(p)) {
            return;
        }
        for (const std::size_t d : directions) {
            const Place ahead = moved(p, d, 1);
            bool free = map_.passable(ahead);
            if (d >= 4) {
                free = free && map_.passable(moved(p, d - 4, 1)) &&
                       map_.passable(moved(p, (d - 3) % 4, 1));
            }
            if (free) {
                const int more = subgoal(ahead) ? 0 : steps_[ahead][d];
                steps_[p][d] = static_cast<std::uint16_t>(1 + more);
            }
        }
    }

    const GridMap& map_;
    std::array<std::int32_t, kCompass> offset_{};
    std::span<const Subgoal> numbers_;  // by place
    std::unique_ptr<Steps[]> steps_;    // by place; of rows that were taken
};

void find_corners(const GridMap& map, int y, std::vector<Place>& found) {
    const auto stride = static_cast<std::int32_t>(map.stride());
    for (int x = 0; x < map.width(); ++x) {
        const Place p = map.place({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
        const auto passable = [&map, p](std::int32_t offset) {
            return map.passable(static_cast<Place>(static_cast<std::int32_t>(p) + offset));
        };
        const auto corner = [&passable, stride](std::int32_t dx, std::int32_t dy) {
            return passable(dx) && passable(dy * stride) && !passable(dx + dy * stride);
        };
        if (map.passable(p) && (corner(1, 1) || corner(1, -1) || corner(-1, 1) || corner(-1, -1))) {
            found.push_back(p);
        }
    }
}

/// Finds all subgoals that p sees. They lie straight ahead, or in the wedge between a diagonal and
/// a direction beside it. In the wedge each line goes only as far as the lines nearer to the start
/// allow (algorithm 1 of the paper).
template <class Found>
void look_around(const Clearances& clear, Place p, const Found& found) {
    for (std::size_t d = 0; d < kCompass; ++d) {
        const int steps = clear.steps(p, d);
        const Place end = clear.moved(p, d, steps);
        if (steps > 0 && clear.subgoal(end)) {
            found(end);
        }
    }
    for (std::size_t d = 4; d < kCompass; ++d) {
        int far = clear.steps(p, d);
        far -= far > 0 && clear.subgoal(clear.moved(p, d, far)) ? 1 : 0;
        for (const std::size_t side : {d - 4, (d - 3) % 4}) {
            int most = clear.steps(p, side);
            most -= most > 0 && clear.subgoal(clear.moved(p, side, most)) ? 1 : 0;
            for (int i = 1; i <= far && most > 0; ++i) {
                const Place on = clear.moved(p, d, i);
                int steps = clear.steps(on, side);
                const Place end = clear.moved(on, side, steps);
                if (steps > 0 && steps <= most && clear.subgoal(end)) {
                    found(end);
                    --steps;
                }
                most = std::min(most, steps);
            }
        }
    }
}

/// The jump point that a ray meets first, in each of four directions; kNoPlace where a blocked cell
/// comes first.
class Rays {
  public:
    explicit Rays(const GridMap& map)
        : map_(map),
          meets_(std::make_unique_for_overwrite<Places[]>(map.places())),
          next_(std::make_unique_for_overwrite<Places[]>(map.places())) {
        const auto stride = static_cast<std::int32_t>(map.stride());
        for (std::size_t d = 0; d < 4; ++d) {
            offset_[d] = kCompassX[d] + kCompassY[d] * stride;
        }
    }

    /// First all rows downwards, then all upwards. Memory is first touched row by row, too.
    void take_row(int y, bool downwards) {
        const Place first = map_.place({0, static_cast<std::uint16_t>(y)});
        const auto width = static_cast<Place>(map_.width());
        for (Place i = 0; i < width; ++i) {
            if (downwards) {
                take(first + i, 2);
                take(first + i, 3);
                take_diagonal(first + i, 2);
            } else {
                take(first + width - 1 - i, 0);
                take(first + width - 1 - i, 1);
                take_diagonal(first + width - 1 - i, 0);
                take_diagonal(first + width - 1 - i, 1);
            }
        }
    }

    /// Before the doors of a row; rows from the top, once all are taken.
    void finish_row(int y) {
        const Place first = map_.place({0, static_cast<std::uint16_t>(y)});
        for (Place i = 0; i < static_cast<Place>(map_.width()); ++i) {
            take_diagonal(first + i, 3);
        }
    }

    /// All that a passable place has for doors, each once.
    template <class Found>
    void doors(Place p, const Found& found) const {
        for (std::size_t d = 0; d < 4; ++d) {
            meet(p, d, found);
        }
        for (std::size_t d = 0; d < 4; ++d) {
            for (Place on = next_[p][d]; on != kNoPlace; on = next_[on][d]) {
                meet(on, d, found);
                meet(on, (d + 1) % 4, found);
            }
        }
    }

  private:
    using Places = std::array<Place, 4>;

    [[nodiscard]] bool passable(Place p, std::int32_t offset) const {
        return map_.passable(static_cast<Place>(static_cast<std::int32_t>(p) + offset));
    }

    template <class Found>
    void meet(Place p, std::size_t d, const Found& found) const {
        if (meets_[p][d] != kNoPlace) {
            found(meets_[p][d]);
        }
    }

    /// Takes p, after all cells ahead of it.
    void take(Place p, std::size_t d) {
        meets_[p][d] = kNoPlace;
        if (!map_.passable(p) || !passable(p, offset_[d])) {
            return;
        }
        const auto ahead = static_cast<Place>(static_cast<std::int32_t>(p) + offset_[d]);
        const std::int32_t side = offset_[(d + 1) % 4];
        const bool jump = (passable(ahead, side) && !passable(p, side)) ||
                          (passable(ahead, -side) && !passable(p, -side));
        meets_[p][d] = jump ? ahead : meets_[ahead][d];
    }

    /// The next place on the diagonal after direction `d` from which rays meet anything: in open
    /// country nearly none does. Those ahead were taken.
    void take_diagonal(Place p, std::size_t d) {
        const std::int32_t a = offset_[d];
        const std::int32_t b = offset_[(d + 1) % 4];
        next_[p][d] = kNoPlace;
        if (map_.passable(p) && passable(p, a) && passable(p, b) && passable(p, a + b)) {
            const auto ahead = static_cast<Place>(static_cast<std::int32_t>(p) + a + b);
            const bool meets =
                meets_[ahead][d] != kNoPlace || meets_[ahead][(d + 1) % 4] != kNoPlace;
            next_[p][d] = meets ? ahead : next_[ahead][d];
        }
    }

    const GridMap& map_;
    std::array<std::int32_t, 4> offset_{};
    std::unique_ptr<Places[]> meets_;  // by place; of rows that were taken
    std::unique_ptr<Places[]> next_;   // by place, the next one on each diagonal
};

}  // namespace

std::optional<Subgoals> Subgoals::build(const GridMap& map, std::size_t most_doors) {
    std::optional<Subgoals> built;
    build(map, most_doors, built).advance(~std::uint64_t{0});
    return built;
}

ResumableTask Subgoals::build(const GridMap& map,
                              std::size_t most_doors,
                              std::optional<Subgoals>& built) {
    // Units are about 2 ns.
    constexpr std::uint64_t kPlaceUnits = 5;
    constexpr std::uint64_t kDoorUnits = 8;
    constexpr std::uint64_t kSeenUnits = 10;
    constexpr std::uint64_t kAroundUnits = 60;  // of a subgoal
    // Room for this many, enough for most subgoals, is taken at once. So no page of it is touched
    // before its turn, and nothing large is copied meanwhile.
    constexpr std::size_t kSeenByMost = 32;
    built.reset();
    Subgoals s;
    const Spent row{kPlaceUnits * static_cast<std::uint64_t>(map.width())};
    for (int y = 0; y < map.height(); ++y) {
        find_corners(map, y, s.place_);
        if (co_await row) {
            co_return;
        }
    }
    s.cells_.reserve(s.place_.size());
    std::vector<Subgoal> number;
    number.reserve(map.places());
    for (std::size_t next = 0; number.size() < map.places();) {
        const std::size_t end = std::min<std::size_t>(map.places(), number.size() + map.stride());
        number.resize(end, kNoSubgoal);
        for (; next < s.place_.size() && s.place_[next] < end; ++next) {
            number[s.place_[next]] = s.size();
            s.cells_.push_back(map.cell(s.place_[next]));
        }
        if (co_await Spent{memory_units(map.stride() * sizeof(Subgoal))}) {
            co_return;
        }
    }
    {
        Rays rays(map);
        const Spent touched{row.units + memory_units(map.stride() * 8 * sizeof(Place))};
        for (int i = 0; i < 2 * map.height(); ++i) {
            const bool down = i < map.height();
            rays.take_row(down ? i : 2 * map.height() - 1 - i, down);
            if (co_await (down ? touched : row)) {
                co_return;
            }
        }
        s.first_door_.reserve(map.places() + std::size_t{1});
        s.first_door_.push_back(0);
        s.doors_.reserve(std::min<std::size_t>(most_doors, std::size_t{16} * map.places()));
        bool fits = true;
        for (Place end = map.stride(); s.first_door_.size() <= map.places(); end += map.stride()) {
            const std::size_t before = s.doors_.size();
            const int y =
                static_cast<int>(end / map.stride()) - 3;  // two rows of border come first
            if (y >= 0 && y < map.height()) {
                rays.finish_row(y);
            }
            for (Place p = end - map.stride(); p < end; ++p) {
                if (map.passable(p)) {
                    rays.doors(p, [&](Place q) {
                        fits = fits && s.doors_.size() < most_doors;
                        if (fits) {
                            s.doors_.push_back(number[q]);
                        }
                    });
                }
                s.first_door_.push_back(static_cast<std::uint32_t>(s.doors_.size()));
            }
            const std::uint64_t units = 2 * row.units + kDoorUnits * (s.doors_.size() - before) +
                                        memory_units(map.stride() * sizeof(std::uint32_t));
            if (co_await Spent{units} || !fits) {
                co_return;
            }
        }
    }
    if (co_await Spent{memory_units(2 * map.places() * sizeof(Place))}) {  // rays are given back
        co_return;
    }
    Clearances clear(map, number);
    const Spent touched{row.units + memory_units(map.stride() * sizeof(std::uint16_t) * 8)};
    for (int i = 0; i < 2 * map.height(); ++i) {
        const bool down = i < map.height();
        clear.take_row(down ? i : 2 * map.height() - 1 - i, down);
        if (co_await (down ? touched : row)) {
            co_return;
        }
    }
    s.seen_.reserve(kSeenByMost * s.place_.size());
    s.first_seen_.reserve(s.place_.size() + 1);
    s.first_seen_.push_back(0);
    for (const Place p : s.place_) {
        look_around(clear, p, [&s, &number](Place q) { s.seen_.push_back(number[q]); });
        if (co_await Spent{kAroundUnits + kSeenUnits * (s.seen_.size() - s.first_seen_.back())}) {
            co_return;
        }
        s.first_seen_.push_back(static_cast<std::uint32_t>(s.seen_.size()));
    }
    built = std::move(s);
}

Subgoal Subgoals::at(Place p) const {
    const auto found = std::lower_bound(place_.begin(), place_.end(), p);
    return found != place_.end() && *found == p ? static_cast<Subgoal>(found - place_.begin())
                                                : kNoSubgoal;
}

std::size_t Subgoals::bytes() const {
    // Of the room taken beforehand only the used part is in memory.
    return cells_.size() * sizeof(Cell) + place_.size() * sizeof(Place) +
           (first_seen_.size() + first_door_.size()) * sizeof(std::uint32_t) +
           (seen_.size() + doors_.size()) * sizeof(Subgoal);
}

}  // namespace zoned::ai::pathfinding
