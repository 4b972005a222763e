#include "server/ai/pathfinding/grid/ground_map.h"

#include "server/ai/pathfinding/grid/plan_rect.h"
#include "server/ai/pathfinding/grid/step_trial.h"
#include "shared/core/containers/union_find.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

namespace zoned::ai::pathfinding {

namespace {

using motion::CharacterLimits;
using motion::StaticGeometry;

/// The most floors of a cell that are tested.
constexpr std::uint32_t kMostFloors = 4;
constexpr float kSameFloor_m = 0.02F;
constexpr std::uint32_t kNoFloor = ~0U;
/// The side of a block, in cells.
constexpr std::size_t kBlock = 8;
/// Smaller ground that cannot be reached from elsewhere does not count: tops of walls and crates.
constexpr float kSmallestIsland_m2 = 4.0F;
constexpr std::array<int, 4> kAheadX{1, 0, 1, -1};
constexpr std::array<int, 4> kAheadY{0, 1, 1, 1};

/// Near: the kinds of things that a step from a cell may touch.
enum Near : std::uint8_t {
    kOpen,    ///< the ground plane alone, and nothing is near
    kPlain,   ///< the ground plane alone: the capsule is put down on it, as beside things
    kGentle,  ///< heights alone, that carry
    kTried,   ///< whatever else: its steps are tried
};

/// Most cells of a zone are open country, or plain. These make runs along rows, each of which is a
/// single floor; all steps on these can be made. The others are busy: each has floors of its own,
/// and steps that may have to be tried. So the work follows what stands in the zone.
class Bakery {
  public:
    Bakery(const StaticGeometry& world, const CharacterLimits& limits, GroundMap& out)
        : world_(world),
          limits_(limits),
          out_(out),
          words_(out.cells.stride() / 64),
          near_(out.cells.places(), kOpen),
          busy_(out.cells.row_bits().size(), 0),
          blocks_across_((static_cast<std::size_t>(out.grid.width()) + kBlock - 1) / kBlock),
          trials_(blocks_across_ *
                  ((static_cast<std::size_t>(out.grid.height()) + kBlock - 1) / kBlock)) {
        // The plane alone is the same everywhere.
        const StaticGeometry bare({}, world.ground_height());
        const std::optional<float> floor =
            StepTrial(bare, limits, out.grid.cell_m()).stand({}, bare.ground_height());
        if (floor && std::abs(*floor - world.ground_height()) <= StepTrial::kLevel) {
            plain_floor_ = floor;
        }
    }

    void run() {
        mark_near();
        for (int y = 0; y < out_.grid.height(); ++y) {
            put_down_row(y);
        }
        first_run_.push_back(static_cast<std::uint32_t>(runs_.size()));
        number_busy();
        join_floors();
        choose_floors();
        block_edges(true);
        // Then the edges of those diagonals only that may still be stepped along.
        block_edges(false);
    }

  private:
    /// Cells of a row from `begin` to `end`, exclusive, that are one floor.
    struct Run {
        Place begin;
        Place end;
        std::uint32_t floor;
    };

    /// The floors of a cell.
    struct Stack {
        std::uint32_t first;
        std::uint32_t count;
    };

    /// Cells from whose middle a step may touch anything but the ground plane.
    void mark_near() {
        const float reach =
            limits_.radius + out_.grid.cell_m() * 1.5F + limits_.step_up + limits_.step_down;
        // Boxes that cannot be touched from the ground plane stand on others, or on surfaces.
        const float ground = world_.ground_height();
        const float head = ground + 2.0F * (limits_.radius + limits_.half_segment) + reach;
        for (std::uint32_t i = 0; i < world_.boxes().size(); ++i) {
            const Aabb& b = world_.box_bounds(i);
            if (b.lower.y() <= head && b.upper.y() >= ground) {
                mark(b, reach, plain_floor_ ? kPlain : kTried);
            }
        }
        for (std::uint32_t i = 0; i < world_.boxes().size() && plain_floor_; ++i) {
            mark_touched(i);
        }
        for (const motion::PlacedSurface& s : world_.surfaces()) {
            if (s.surface().is_grid()) {
                mark_heights(s, reach);
            } else {
                mark(s.bounds(), reach, kTried);
            }
        }
    }

    /// Near a box, the cells from which a half step may touch it are not plain.
    void mark_touched(std::uint32_t box) {
        const float half_step = 0.5F * std::numbers::sqrt2_v<float> * out_.grid.cell_m();
        const float touch = limits_.radius + StepTrial::kClear + half_step;
        const PlanRect plan(world_, box);
        for_each_cell_near(world_.box_bounds(box), touch, [&](Cell c) {
            Near& near = near_[out_.cells.place(c)];
            if (near == kPlain && plan.distance(out_.grid.centre(c)) <= touch) {
                near = kTried;
            }
        });
    }

    /// Over heights that carry wherever a step may touch them, none has to be tried.
    void mark_heights(const motion::PlacedSurface& s, float reach) {
        for_each_cell_near(s.bounds(), reach, [&](Cell c) {
            const Place p = out_.cells.place(c);
            const Spot at = out_.grid.centre(c);
            const bool inside =
                s.top_at(at.x - reach, at.z - reach) && s.top_at(at.x + reach, at.z - reach) &&
                s.top_at(at.x - reach, at.z + reach) && s.top_at(at.x + reach, at.z + reach);
            near_[p] = inside && near_[p] == kOpen ? kGentle : kTried;
        });
        s.surface().for_each_near(s.surface().box(), [&](const FacedTriangle& t) {
            if (t.normal.y() < limits_.max_slope_cos + StepTrial::kSlopeMargin) {
                const Vec3 a = s.to_world(t.corner[0]);
                const Vec3 b = s.to_world(t.corner[1]);
                const Vec3 c = s.to_world(t.corner[2]);
                mark({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)}, reach, kTried);
            }
        });
    }

    void mark(const Aabb& bounds, float reach, Near kind) {
        for_each_cell_near(bounds, reach, [&](Cell c) { near_[out_.cells.place(c)] = kind; });
    }

    template <class Visit>
    void for_each_cell_near(const Aabb& bounds, float reach, const Visit& visit) const {
        const Spot low{bounds.lower.x() - reach, bounds.lower.z() - reach};
        const Spot high{bounds.upper.x() + reach, bounds.upper.z() + reach};
        const GroundGrid& g = out_.grid;
        const float right = g.min_x() + static_cast<float>(g.width()) * g.cell_m();
        const float below = g.min_z() + static_cast<float>(g.height()) * g.cell_m();
        if (low.x > right || low.z > below || high.x < g.min_x() || high.z < g.min_z()) {
            return;
        }
        const Cell a = g.cell(low);
        const Cell b = g.cell(high);
        for (int y = a.y; y <= b.y; ++y) {
            for (int x = a.x; x <= b.x; ++x) {
                visit(Cell{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
            }
        }
    }

    static bool is_busy(Near near) { return near == kGentle || near == kTried; }

    [[nodiscard]] bool is_busy(Place p) const { return (busy_[p >> 6U] >> (p & 63U) & 1U) != 0; }

    void add_floor(float height, std::uint32_t cells) {
        floors_.push_back(height);
        cells_.push_back(cells);
    }

    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(floors_.size()); }

    /// Finds the runs of a row, and the lowest floors of its busy cells, from left to right.
    void put_down_row(int y) {
        first_run_.push_back(static_cast<std::uint32_t>(runs_.size()));
        const Place first = out_.cells.place({0, static_cast<std::uint16_t>(y)});
        const Place end = first + static_cast<Place>(out_.grid.width());
        for (Place p = first; p < end;) {
            const Near near = near_[p];
            if (is_busy(near)) {
                busy_[p >> 6U] |= std::uint64_t{1} << (p & 63U);
                put_down(p++);
                continue;
            }
            const Place begin = p;
            while (p < end && near_[p] == near) {
                ++p;
            }
            runs_.push_back({begin, p, size()});
            add_floor(near == kOpen ? world_.ground_height() : *plain_floor_, p - begin);
        }
    }

    void put_down(Place p) {
        const std::uint32_t first = size();
        const Cell c = out_.cells.cell(p);
        const Spot at = out_.grid.centre(c);
        StepTrial& trial = trial_at(c);
        for (const float top : trial.tops(at)) {
            const std::optional<float> floor = trial.stand(at, top);
            // Floors within a ledge's height of each other count as one.
            if (floor && (size() == first || *floor > floors_.back() + kSameFloor_m)) {
                add_floor(*floor, 1);
                if (size() == first + kMostFloors) {
                    break;
                }
            }
        }
        stacks_.push_back({first, size() - first});
    }

    void number_busy() {
        std::uint32_t count = 0;
        rank_.reserve(busy_.size());
        for (const std::uint64_t word : busy_) {
            rank_.push_back(count);
            count += static_cast<std::uint32_t>(std::popcount(word));
        }
    }

    /// The number of a busy place among these.
    [[nodiscard]] std::uint32_t busy_number(Place p) const {
        const std::uint64_t before = (std::uint64_t{1} << (p & 63U)) - 1;
        return rank_[p >> 6U] + static_cast<std::uint32_t>(std::popcount(busy_[p >> 6U] & before));
    }

    [[nodiscard]] Stack floors_at(Cell c) const {
        const Place p = out_.cells.place(c);
        if (is_busy(p)) {
            return stacks_[busy_number(p)];
        }
        const auto row = runs_.begin() + first_run_[c.y];
        const auto next = std::upper_bound(
            row, runs_.begin() + first_run_[c.y + 1U], p, [](Place at, const Run& run) {
                return at < run.begin;
            });
        return {(next - 1)->floor, 1};
    }

    /// Calls `visit(c, to, ahead)` for each pair of cells of the map that touch, if one of them is
    /// busy; by the place of the first.
    template <class Visit>
    void for_each_busy_pair(const Visit& visit) {
        for (int y = 0; y < out_.grid.height(); ++y) {
            const std::size_t row = (static_cast<std::size_t>(y) + 2) * words_;
            for (std::size_t w = row; w < row + words_; ++w) {
                // A place before the row's first cell, or behind its last, is no cell.
                for (std::uint64_t rest = with_busy_ahead(w); rest != 0; rest &= rest - 1) {
                    const auto bit = static_cast<std::size_t>(std::countr_zero(rest));
                    const int x = static_cast<int>((w - row) * 64 + bit) - 1;
                    if (x >= 0 && x < out_.grid.width()) {
                        visit_ahead(x, y, visit);
                    }
                }
            }
        }
    }

    /// Of the places of a word, those that are busy or from which one ahead is, as bits.
    [[nodiscard]] std::uint64_t with_busy_ahead(std::size_t w) const {
        const std::uint64_t* const here = busy_.data() + w;
        const std::uint64_t* const below = here + words_;
        return *here | *here >> 1U | here[1] << 63U | *below | *below >> 1U | below[1] << 63U |
               *below << 1U | *(below - 1) >> 63U;
    }

    template <class Visit>
    void visit_ahead(int x, int y, const Visit& visit) {
        const Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
        const bool busy = is_busy(out_.cells.place(c));
        for (unsigned i = 0; i < kAheadX.size(); ++i) {
            const Cell to{static_cast<std::uint16_t>(x + kAheadX[i]),
                          static_cast<std::uint16_t>(y + kAheadY[i])};
            if (out_.cells.contains(to) && (busy || is_busy(out_.cells.place(to)))) {
                visit(c, to);
            }
        }
    }

    /// Which floors of neighbours are a step apart, and which reach each other by steps.
    void join_floors() {
        joined_.reset(floors_.size());
        join_runs();
        for_each_busy_pair([this](Cell c, Cell to) {
            const Stack from = floors_at(c);
            const Stack next = floors_at(to);
            std::uint16_t made = 0;
            for (std::uint32_t a = from.first; a < from.first + from.count; ++a) {
                for (std::uint32_t b = next.first; b < next.first + next.count; ++b) {
                    const bool up = floors_[b] > floors_[a];
                    if (up ? steps(c, to, a, b) : steps(to, c, b, a)) {
                        made |= step_bit(a - from.first, b - next.first);
                        joined_.join(a, b);
                    }
                }
            }
            steps_.push_back(made);
        });
    }

    static std::uint16_t step_bit(std::uint32_t from, std::uint32_t to) {
        return static_cast<std::uint16_t>(1U << (from * kMostFloors + to));
    }

    /// Runs that touch, along rows and from row to row.
    void join_runs() {
        for (std::size_t y = 0; y + 1 < first_run_.size(); ++y) {
            const std::uint32_t end = first_run_[y + 1];
            std::uint32_t above = y == 0 ? 0 : first_run_[y - 1];
            for (std::uint32_t i = first_run_[y]; i < end; ++i) {
                const Run& run = runs_[i];
                if (i + 1 < end && runs_[i + 1].begin == run.end) {
                    joined_.join(run.floor, runs_[i + 1].floor);
                }
                // Corners touch too.
                const Place begin = run.begin - out_.cells.stride();
                const Place last = run.end - out_.cells.stride();
                const std::uint32_t stop = y == 0 ? 0 : first_run_[y];
                while (above < stop && runs_[above].end < begin) {
                    ++above;
                }
                for (std::uint32_t j = above; j < stop && runs_[j].begin <= last; ++j) {
                    joined_.join(runs_[j].floor, run.floor);
                }
            }
        }
    }

    void choose_floors() {
        std::vector<std::uint32_t> cells(floors_.size(), 0);
        for (std::uint32_t f = 0; f < floors_.size(); ++f) {
            cells[joined_.root(f)] += cells_[f];
        }
        const auto main = static_cast<std::uint32_t>(std::max_element(cells.begin(), cells.end()) -
                                                     cells.begin());
        const float cell = out_.grid.cell_m();
        const auto fewest = static_cast<std::uint32_t>(kSmallestIsland_m2 / (cell * cell));
        std::vector<std::uint64_t> passable(busy_.size(), 0);
        for (const Run& run : runs_) {
            if (joined_.root(run.floor) == main || cells[joined_.root(run.floor)] >= fewest) {
                set_bits(passable, run.begin, run.end);
                std::fill(out_.floor_m.begin() + run.begin,
                          out_.floor_m.begin() + run.end,
                          floors_[run.floor]);
            }
        }
        chosen_.assign(stacks_.size(), kNoFloor);
        for_each_busy([&](Place p, std::uint32_t number) {
            const Stack stack = stacks_[number];
            std::uint32_t& chosen = chosen_[number];
            for (std::uint32_t f = stack.first; f < stack.first + stack.count; ++f) {
                const bool best = joined_.root(f) == main;
                if (best || (chosen == kNoFloor && cells[joined_.root(f)] >= fewest)) {
                    chosen = f;
                }
            }
            if (chosen != kNoFloor) {
                out_.floor_m[p] = floors_[chosen];
                set_bits(passable, p, p + 1);
            }
        });
        out_.cells.set_all(passable);
    }

    /// Calls `visit(place, number)` for each busy place.
    template <class Visit>
    void for_each_busy(const Visit& visit) const {
        std::uint32_t number = 0;
        for (std::size_t w = 0; w < busy_.size(); ++w) {
            for (std::uint64_t rest = busy_[w]; rest != 0; rest &= rest - 1) {
                visit(static_cast<Place>(w * 64 + static_cast<std::size_t>(std::countr_zero(rest))),
                      number++);
            }
        }
    }

    /// Sets the bits from `begin` to `end`, exclusive.
    static void set_bits(std::vector<std::uint64_t>& bits, Place begin, Place end) {
        for (Place p = begin; p < end;) {
            const Place next = std::min(end, (p | 63U) + 1);
            const std::uint64_t all = ~std::uint64_t{0} >> (64U - (next - p));
            bits[p >> 6U] |= all << (p & 63U);
            p = next;
        }
    }

    /// The chosen floor of a passable cell, from its lowest.
    [[nodiscard]] std::uint32_t chosen_at(Place p) const {
        if (!is_busy(p)) {
            return 0;
        }
        const std::uint32_t number = busy_number(p);
        return chosen_[number] - stacks_[number].first;
    }

    void block_edges(bool straight) {
        std::size_t pair = 0;
        for_each_busy_pair([&](Cell c, Cell to) {
            const std::uint16_t made = steps_[pair++];
            const Place p = out_.cells.place(c);
            const Place q = out_.cells.place(to);
            if (near_[p] != kTried && near_[q] != kTried) {
                return;  // joined already, see steps()
            }
            if ((c.x == to.x || c.y == to.y) != straight || !out_.cells.passable(p) ||
                !out_.cells.passable(q) || !out_.cells.passable(Cell{c.x, to.y}) ||
                !out_.cells.passable(Cell{to.x, c.y})) {
                return;
            }
            if ((made & step_bit(chosen_at(p), chosen_at(q))) == 0) {
                const Cell higher = out_.floor_m[q] > out_.floor_m[p] ? to : c;
                out_.cells.set_passable(higher, false);
                out_.floor_m[out_.cells.place(higher)] = 0.0F;
            }
        });
    }

    /// True if a character walks from the middle of a cell to that of its neighbour, from floor `a`
    /// to floor `b`.
    [[nodiscard]] bool steps(Cell from, Cell to, std::uint32_t a, std::uint32_t b) {
        return (near_[out_.cells.place(from)] != kTried && near_[out_.cells.place(to)] != kTried) ||
               trial_at(from).walks({out_.grid.centre(from), floors_[a]},
                                    {out_.grid.centre(to), floors_[b]});
    }

    /// For places in the block of a cell. It knows what is near them, so that each of its many
    /// queries looks at little.
    StepTrial& trial_at(Cell c) {
        std::unique_ptr<StepTrial>& trial = trials_[c.y / kBlock * blocks_across_ + c.x / kBlock];
        if (trial == nullptr) {
            const float cell = out_.grid.cell_m();
            const float side = cell * static_cast<float>(kBlock);
            const float reach = StepTrial::reach_m(limits_, cell);
            const float x = out_.grid.min_x() + side * static_cast<float>(c.x / kBlock);
            const float z = out_.grid.min_z() + side * static_cast<float>(c.y / kBlock);
            const Aabb area{Vec3(x - reach, -StepTrial::kEverywhere_m, z - reach),
                            Vec3(x + side + reach, StepTrial::kEverywhere_m, z + side + reach)};
            trial = std::make_unique<StepTrial>(world_.around(area), limits_, cell);
        }
        return *trial;
    }

    const StaticGeometry& world_;
    CharacterLimits limits_;
    GroundMap& out_;
    std::optional<float> plain_floor_;  // none: no cell is plain
    std::size_t words_;                 // of a row
    std::vector<Near> near_;            // by place
    std::vector<std::uint64_t> busy_;   // bit p: the place is busy
    std::size_t blocks_across_;
    std::vector<std::unique_ptr<StepTrial>> trials_;  // by block; made where it has busy cells
    std::vector<std::uint32_t> rank_;                 // by word: the busy places before it
    std::vector<Run> runs_;                           // by place
    std::vector<std::uint32_t> first_run_;            // by row, and one more
    std::vector<Stack> stacks_;                       // by busy place
    std::vector<float> floors_;                       // m, by place, of each cell from the lowest
    std::vector<std::uint32_t> cells_;                // by floor
    std::vector<std::uint16_t> steps_;   // by busy pair: which floors are a step apart, as bits
    core::UnionFind joined_;             // floors that reach each other
    std::vector<std::uint32_t> chosen_;  // floor, by busy place
};

}  // namespace

GroundMap bake_ground(const StaticGeometry& world,
                      const CharacterLimits& limits,
                      const GroundRect& area,
                      float cell_m) {
    const GroundGrid grid(area, cell_m);
    GroundMap out{grid, GridMap(grid.width(), grid.height()), {}};
    out.floor_m.assign(out.cells.places(), 0.0F);
    Bakery(world, limits, out).run();
    return out;
}

}  // namespace zoned::ai::pathfinding
