#include "server/ai/pathfinding/grid/ground_map.h"

#include "server/ai/pathfinding/grid/box_column.h"
#include "shared/core/containers/union_find.h"
#include "shared/core/elementary/elementary.h"
#include "shared/math/closest.h"
#include "shared/motion/capsule_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace zoned::ai::pathfinding {

namespace {

using motion::CapsuleSweep;
using motion::CharacterLimits;
using motion::StaticGeometry;
using motion::SweepHit;

/// A capsule that overlaps nothing is put down from so far above, m.
constexpr float kAbove = 0.01F;
/// Ticks of a trial step are so short that the capsule moves by this share of its radius at most:
/// apply_input climbs one ledge's height in a tick.
constexpr float kShareOfRadius = 0.5F;
/// A step has arrived that ends as near to the middle of its cell, in cells.
constexpr float kOffMiddle = 0.15F;
/// Ground is gentle if it is this much less steep than the steepest that carries, as a cosine.
constexpr float kSlopeMargin = 0.02F;
/// The most floors of a cell that are tested.
constexpr std::uint32_t kMostFloors = 4;
constexpr float kSameFloor_m = 0.02F;
/// Things farther from a capsule than this are not touched by it, m: ten times the air that it
/// keeps.
constexpr float kClear = 10.0F * motion::kSkin;
/// Heights that differ by less are one level, m.
constexpr float kLevel = 2.0F * motion::kSkin;
/// Boxes that lean by less count as upright, as a cosine: half a millimetre on a metre.
constexpr float kUpright = 1.0F - 1e-7F;
constexpr std::uint32_t kNoFloor = ~0U;
/// Smaller ground that cannot be reached from elsewhere does not count: tops of walls and crates.
constexpr float kSmallestIsland_m2 = 4.0F;
constexpr std::array<int, 4> kAheadX{1, 0, 1, -1};
constexpr std::array<int, 4> kAheadY{0, 1, 1, 1};

/// Near: the kinds of things that a step from a cell may touch.
enum Near : std::uint8_t {
    kOpen,    ///< the ground plane alone
    kGentle,  ///< heights alone, that carry
    kTried,   ///< whatever else: its steps are tried
};

class Bakery {
  public:
    Bakery(const StaticGeometry& world, const CharacterLimits& limits, GroundMap& out)
        : world_(world),
          limits_(limits),
          out_(out),
          capsule_{limits.radius, limits.half_segment},
          half_height_(limits.radius + limits.half_segment),
          near_(out.cells.places(), kOpen) {
        // Trial steps go at the speed they begin with, wherever they lead.
        limits_.speed = 1.0F;
        const float carried = std::clamp(limits.max_slope_cos, 0.1F, 1.0F);
        slope_rise_ = limits.radius * (1.0F / carried - 1.0F);
    }

    void run() {
        mark_near();
        first_.assign(out_.cells.places() + std::size_t{1}, 0);
        for (int y = 0; y < out_.grid.height(); ++y) {
            for (int x = 0; x < out_.grid.width(); ++x) {
                put_down(x, y);
            }
            // Places beside the map have no floors.
            const Place next = out_.cells.place({0, static_cast<std::uint16_t>(y + 1)});
            const Place after = out_.cells.place({0, static_cast<std::uint16_t>(y)}) +
                                static_cast<Place>(out_.grid.width());
            std::fill(first_.begin() + after, first_.begin() + next, size());
        }
        std::fill(
            first_.begin() + out_.cells.place({0, static_cast<std::uint16_t>(out_.grid.height())}),
            first_.end(),
            size());
        join_floors();
        choose_floors();
        block_edges();
    }

  private:
    /// Cells from whose middle a step may touch anything but the ground plane.
    void mark_near() {
        const float reach =
            limits_.radius + out_.grid.cell_m() * 1.5F + limits_.step_up + limits_.step_down;
        // Boxes that cannot be touched from the ground plane stand on others, or on surfaces.
        const float ground = world_.ground_height();
        for (std::uint32_t i = 0; i < world_.boxes().size(); ++i) {
            const Aabb& b = world_.box_bounds(i);
            if (b.lower.y() <= ground + 2.0F * half_height_ + reach && b.upper.y() >= ground) {
                mark(b, reach);
            }
        }
        for (const motion::PlacedSurface& s : world_.surfaces()) {
            if (s.surface().is_grid()) {
                mark_heights(s, reach);
            } else {
                mark(s.bounds(), reach);
            }
        }
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
            if (t.normal.y() < limits_.max_slope_cos + kSlopeMargin) {
                const Vec3 a = s.to_world(t.corner[0]);
                const Vec3 b = s.to_world(t.corner[1]);
                const Vec3 c = s.to_world(t.corner[2]);
                mark({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)}, reach);
            }
        });
    }

    void mark(const Aabb& bounds, float reach) {
        for_each_cell_near(bounds, reach, [this](Cell c) { near_[out_.cells.place(c)] = kTried; });
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

    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(floors_.size()); }

    /// Finds the lowest floors of a cell.
    void put_down(int x, int y) {
        const Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
        const Place p = out_.cells.place(c);
        first_[p] = size();
        if (near_[p] == kOpen) {
            floors_.push_back(world_.ground_height());
            return;
        }
        const Spot at = out_.grid.centre(c);
        find_tops(at);
        for (const float top : tops_) {
            const std::optional<float> floor = stand(at, top);
            // Floors within a ledge's height of each other count as one.
            if (floor && (size() == first_[p] || *floor > floors_.back() + kSameFloor_m)) {
                floors_.push_back(*floor);
                if (size() == first_[p] + kMostFloors) {
                    return;
                }
            }
        }
    }

    /// Heights over the place on which something may stand, from the lowest.
    void find_tops(Spot at) {
        tops_.clear();
        float solid = world_.ground_height();
        for (const motion::PlacedSurface& s : world_.surfaces()) {
            if (const std::optional<float> top = s.top_at(at.x, at.z)) {
                tops_.push_back(*top);
                solid = s.surface().is_grid() ? std::max(solid, *top) : solid;
            }
        }
        tops_.push_back(world_.ground_height());
        const Aabb line{Vec3(at.x, solid, at.z), Vec3(at.x, 1e6F, at.z)};
        world_.for_each_near(line, [&](std::uint32_t box) {
            if (const auto column = column_of_box(world_, box, at.x, at.z)) {
                tops_.push_back(column->top);
            }
        });
        std::erase_if(tops_, [solid](float top) { return top < solid; });
        std::sort(tops_.begin(), tops_.end());
        tops_.erase(std::unique(tops_.begin(), tops_.end()), tops_.end());
    }

    /// The height of its lowest point where the capsule comes to rest when it is put down there.
    std::optional<float> stand(Spot at, float top) const {
        const float ledge = limits_.step_up + slope_rise_;
        const Vec3 low(at.x, top + half_height_, at.z);
        const CapsuleSweep sweep(
            world_, capsule_, {low, low + Vec3(0.0F, ledge + 2.0F * kAbove, 0.0F)});
        for (const motion::PlacedSurface& s : world_.surfaces()) {
            if (s.surface().behind(s.to_local(low + Vec3(0.0F, kAbove, 0.0F)))) {
                return std::nullopt;
            }
        }
        for (const float above : {kAbove, slope_rise_ + kAbove, ledge + kAbove}) {
            const Vec3 begin = low + Vec3(0.0F, above, 0.0F);
            if (sweep.parted(begin) != begin) {
                continue;
            }
            const float drop = above + kAbove;
            const SweepHit hit =
                sweep.sweep_down(begin, drop, [this](const SweepHit& h) { return carries(h); });
            if (!hit.hit || !carries(hit)) {
                return std::nullopt;
            }
            const float floor = begin.y() - hit.fraction * drop - half_height_;
            // On a rim: only if from below the whole ledge can be climbed.
            const float rim = floor + limits_.radius * (1.0F - hit.normal.y());
            const bool on_rim = hit.face_up > hit.normal.y() + 0.001F;
            return on_rim && rim > top + limits_.step_up + motion::kSkin
                       ? std::nullopt
                       : std::optional<float>(floor);
        }
        return std::nullopt;
    }

    /// As in apply_input: ground that is not too steep, or the rim of a ledge that is low enough.
    [[nodiscard]] bool carries(const SweepHit& hit) const {
        const float up = hit.normal.y();
        return up >= limits_.max_slope_cos || (hit.face_up >= limits_.max_slope_cos && up >= 0.1F &&
                                               limits_.radius * (1.0F - up) <= limits_.step_up);
    }

    /// Calls `visit(c, to, ahead)` for each pair of cells of the map that touch.
    template <class Visit>
    void for_each_pair(const Visit& visit) {
        for (int y = 0; y < out_.grid.height(); ++y) {
            for (int x = 0; x < out_.grid.width(); ++x) {
                for (unsigned i = 0; i < kAheadX.size(); ++i) {
                    const Cell to{static_cast<std::uint16_t>(x + kAheadX[i]),
                                  static_cast<std::uint16_t>(y + kAheadY[i])};
                    if (out_.cells.contains(to)) {
                        visit(Cell{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)},
                              to,
                              i);
                    }
                }
            }
        }
    }

    /// Which floors of neighbours are a step apart, and which reach each other by steps.
    void join_floors() {
        steps_.assign(floors_.size(), 0);
        joined_.reset(floors_.size());
        for_each_pair([this](Cell c, Cell to, unsigned ahead) {
            const Place p = out_.cells.place(c);
            const Place q = out_.cells.place(to);
            for (std::uint32_t a = first_[p]; a < first_[p + 1]; ++a) {
                for (std::uint32_t b = first_[q]; b < first_[q + 1]; ++b) {
                    const bool up = floors_[b] > floors_[a];
                    if (up ? steps(c, to, a, b) : steps(to, c, b, a)) {
                        steps_[a] |= step_bit(ahead, b - first_[q]);
                        joined_.join(a, b);
                    }
                }
            }
        });
    }

    static std::uint16_t step_bit(unsigned ahead, std::uint32_t floor) {
        return static_cast<std::uint16_t>(1U << (ahead * kMostFloors + floor));
    }

    void choose_floors() {
        std::vector<std::uint32_t> cells(floors_.size(), 0);
        for (std::uint32_t f = 0; f < floors_.size(); ++f) {
            ++cells[joined_.root(f)];
        }
        const auto main = static_cast<std::uint32_t>(std::max_element(cells.begin(), cells.end()) -
                                                     cells.begin());
        const float cell = out_.grid.cell_m();
        const auto fewest = static_cast<std::uint32_t>(kSmallestIsland_m2 / (cell * cell));
        chosen_.assign(out_.cells.places(), kNoFloor);
        for (Place p = 0; p < out_.cells.places(); ++p) {
            for (std::uint32_t f = first_[p]; f < first_[p + 1]; ++f) {
                const bool best = joined_.root(f) == main;
                if (best || (chosen_[p] == kNoFloor && cells[joined_.root(f)] >= fewest)) {
                    chosen_[p] = f;
                }
            }
            if (chosen_[p] != kNoFloor) {
                out_.floor_m[p] = floors_[chosen_[p]];
                out_.cells.set_passable(out_.cells.cell(p), true);
            }
        }
    }

    void block_edges() {
        block_edges(true);
        // Then the edges of those diagonals only that may still be stepped along.
        block_edges(false);
    }

    void block_edges(bool straight) {
        for_each_pair([&](Cell c, Cell to, unsigned ahead) {
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
            if ((steps_[chosen_[p]] & step_bit(ahead, chosen_[q] - first_[q])) == 0) {
                const Cell higher = out_.floor_m[q] > out_.floor_m[p] ? to : c;
                out_.cells.set_passable(higher, false);
                out_.floor_m[out_.cells.place(higher)] = 0.0F;
            }
        });
    }

    /// True if a character walks from the middle of a cell to that of its neighbour, from floor `a`
    /// to floor `b`.
    [[nodiscard]] bool steps(Cell from, Cell to, std::uint32_t a, std::uint32_t b) const {
        if (near_[out_.cells.place(from)] != kTried && near_[out_.cells.place(to)] != kTried) {
            return true;
        }
        const Spot begin = out_.grid.centre(from);
        const Spot end = out_.grid.centre(to);
        if (std::abs(floors_[a] - floors_[b]) <= kLevel && is_plain(begin, end, floors_[a])) {
            return true;
        }
        const float cell = out_.grid.cell_m();
        const int dx = to.x - from.x;
        const int dz = to.y - from.y;
        const float path = cell * (dx != 0 && dz != 0 ? std::numbers::sqrt2_v<float> : 1.0F);
        const int ticks =
            static_cast<int>(std::ceil(path / (kShareOfRadius * std::max(limits_.radius, 0.01F))));
        const float carried = std::clamp(limits_.max_slope_cos, 0.1F, 1.0F);
        const float steepest = path * std::sqrt(1.0F - carried * carried) / carried;
        const float ledge = limits_.step_up + 0.1F * limits_.radius;
        if (floors_[b] - floors_[a] > static_cast<float>(ticks) * ledge + steepest) {
            return false;  // higher than any stair: no need to try
        }
        motion::CharacterState state;
        state.position = Vec3(begin.x, floors_[a] + half_height_, begin.z);
        state.velocity = Vec3(end.x - begin.x, 0.0F, end.z - begin.z) / path;
        state.grounded = true;
        motion::InputCommand command;
        command.move_x = static_cast<std::int8_t>(127 * dx);
        command.move_z = static_cast<std::int8_t>(127 * dz);
        const float a_tick = path / static_cast<float>(ticks);
        const auto off_m = [&] {
            return elementary::hypot(state.position.x() - end.x, state.position.z() - end.z);
        };
        for (int left = ticks; left > 0 && state.grounded; --left) {
            // Too far behind: neither walking on nor a push out of a box brings it there in time.
            if (off_m() > static_cast<float>(left) * a_tick + kOffMiddle * cell + limits_.radius) {
                return false;
            }
            state = motion::apply_input(state, command, limits_, world_, a_tick);
        }
        const float off_y = state.position.y() - half_height_ - floors_[b];
        return state.grounded && std::abs(off_y) <= ledge + steepest &&
               off_m() <= kOffMiddle * cell;
    }

    /// Whether a character that walks there straight at that height has level ground all along, and
    /// touches nothing else. Most steps near things are such, and this is cheaper than a trial.
    [[nodiscard]] bool is_plain(Spot begin, Spot end, float floor) const {
        const float reach = limits_.radius + kClear;
        const float top = floor + 2.0F * half_height_ + limits_.step_up + kClear;
        const Aabb around{
            Vec3(
                std::min(begin.x, end.x) - reach, floor - kLevel, std::min(begin.z, end.z) - reach),
            Vec3(std::max(begin.x, end.x) + reach, top, std::max(begin.z, end.z) + reach)};
        for (const motion::PlacedSurface& s : world_.surfaces()) {
            if (s.bounds().overlaps(around)) {
                return false;
            }
        }
        bool carried = std::abs(floor - world_.ground_height()) <= kLevel;
        bool clear = true;
        world_.for_each_near(around, [&](std::uint32_t box) {
            if (world_.box_bounds(box).upper.y() <= floor + kLevel) {
                carried = carried || is_level_under(box, begin, end);
            } else {
                clear = clear && distance_in_plan(box, begin, end) > reach;
            }
        });
        return carried && clear;
    }

    [[nodiscard]] bool is_upright(std::uint32_t box) const {
        return std::abs(world_.box_axes(box)(1, 1)) > kUpright;
    }

    /// Whether both places lie over the top face of an upright box.
    [[nodiscard]] bool is_level_under(std::uint32_t box, Spot begin, Spot end) const {
        const motion::StaticBox& b = world_.box(box);
        const auto over = [&](Spot at) {
            const Vec3 local = world_.box_axes(box).transpose() *
                               Vec3(at.x - b.centre.x(), 0.0F, at.z - b.centre.z());
            return std::abs(local.x()) <= b.half_extents.x() &&
                   std::abs(local.z()) <= b.half_extents.z();
        };
        return is_upright(box) && over(begin) && over(end);
    }

    /// Horizontal distance of a box from a line on the ground, m; for one that leans, of its
    /// bounds.
    [[nodiscard]] float distance_in_plan(std::uint32_t box, Spot begin, Spot end) const {
        const Aabb& bounds = world_.box_bounds(box);
        const Mat3& axes = world_.box_axes(box);
        const Vec3 centre = 0.5F * (bounds.lower + bounds.upper);
        const Vec3 middle(
            0.5F * (begin.x + end.x) - centre.x(), 0.0F, 0.5F * (begin.z + end.z) - centre.z());
        const Vec3 half(0.5F * (end.x - begin.x), 0.0F, 0.5F * (end.z - begin.z));
        return is_upright(box)
                   ? segment_box_distance(axes.transpose() * middle,
                                          axes.transpose() * half,
                                          world_.box(box).half_extents)
                         .distance
                   : segment_box_distance(middle, half, 0.5F * (bounds.upper - bounds.lower))
                         .distance;
    }

    const StaticGeometry& world_;
    CharacterLimits limits_;
    GroundMap& out_;
    motion::Capsule capsule_;
    float half_height_;
    float slope_rise_ = 0.0F;
    std::vector<Near> near_;             // by place
    std::vector<std::uint32_t> first_;   // floor, by place and one more
    std::vector<float> floors_;          // m, of each cell from the lowest
    std::vector<std::uint16_t> steps_;   // by floor: neighbours' floors a step ahead, as bits
    core::UnionFind joined_;             // floors that reach each other
    std::vector<std::uint32_t> chosen_;  // floor, by place
    std::vector<float> tops_;
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
