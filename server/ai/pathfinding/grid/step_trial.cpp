#include "server/ai/pathfinding/grid/step_trial.h"

#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace zoned::ai::pathfinding {

namespace {

using motion::CapsuleSweep;
using motion::SweepHit;

/// A capsule that overlaps nothing is put down from so far above, m.
constexpr float kAbove = 0.01F;
/// Ticks of a trial step are so short that the capsule moves by this share of its radius at most:
/// apply_input climbs one ledge's height in a tick.
constexpr float kShareOfRadius = 0.5F;
/// A step has arrived that ends as near to the middle of its cell, in cells.
constexpr float kOffMiddle = 0.15F;
/// Boxes that lean by less count as upright, as a cosine: half a millimetre on a metre.
constexpr float kUpright = 1.0F - 1e-7F;
/// Where more tops of boxes are near a step, it is tried.
constexpr std::size_t kMostTops = 64;

/// The sign of a number as a full move.
std::int8_t full_move(float along) {
    return static_cast<std::int8_t>(along > 0.0F ? 127 : along < 0.0F ? -127 : 0);
}

}  // namespace

StepTrial::StepTrial(const motion::StaticGeometry& world,
                     const motion::CharacterLimits& limits,
                     float cell_m)
    : world_(world),
      limits_(limits),
      cell_m_(cell_m),
      capsule_{limits.radius, limits.half_segment},
      half_height_(limits.radius + limits.half_segment),
      ledge_m_(limits.step_up + 0.1F * limits.radius) {
    // Trial steps go at the speed they begin with, wherever they lead.
    limits_.speed = 1.0F;
    const float carried = std::clamp(limits.max_slope_cos, 0.1F, 1.0F);
    slope_rise_ = limits.radius * (1.0F / carried - 1.0F);
    steepest_ = std::sqrt(1.0F - carried * carried) / carried;
    off_floor_m_ = ledge_m_ + steepest_ * kOffMiddle * cell_m;
    for (std::uint32_t box = 0; box < world_.boxes().size(); ++box) {
        plans_.emplace_back(world_, box);
    }
}

float StepTrial::reach_m(const motion::CharacterLimits& limits, float cell_m) {
    // A diagonal step, once more that far aside, and what movement looks at there.
    return 2.0F * std::numbers::sqrt2_v<float> * cell_m + limits.radius + limits.step_up +
           limits.step_down + 1.0F;
}

std::span<const float> StepTrial::tops(Spot at) {
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
    columns_.clear();
    world_.for_each_near(line, [&](std::uint32_t box) {
        if (const auto column = column_of_box(world_, box, at.x, at.z)) {
            columns_.push_back(*column);
            tops_.push_back(column->top);
        }
    });
    // However high stand() begins there.
    const auto within = [&](float top) {
        const float head = top + 2.0F * half_height_;
        const float most = top + limits_.step_up + slope_rise_ + kAbove + motion::kSkin;
        return std::any_of(columns_.begin(), columns_.end(), [&](const BoxColumn& column) {
            return column.bottom <= head && column.top >= most;
        });
    };
    std::erase_if(tops_, [&](float top) { return top < solid || within(top); });
    std::sort(tops_.begin(), tops_.end());
    tops_.erase(std::unique(tops_.begin(), tops_.end()), tops_.end());
    return tops_;
}

std::optional<float> StepTrial::stand(Spot at, float top) const {
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
        return on_rim && rim > top + limits_.step_up + motion::kSkin ? std::nullopt
                                                                     : std::optional<float>(floor);
    }
    return std::nullopt;
}

/// As in apply_input: ground that is not too steep, or the rim of a ledge that is low enough.
bool StepTrial::carries(const SweepHit& hit) const {
    const float up = hit.normal.y();
    return up >= limits_.max_slope_cos || (hit.face_up >= limits_.max_slope_cos && up >= 0.1F &&
                                           limits_.radius * (1.0F - up) <= limits_.step_up);
}

bool StepTrial::walks(const Foothold& from, const Foothold& to) const {
    const Spot begin = from.at;
    const Spot end = to.at;
    if ((std::abs(from.floor - to.floor) <= kLevel && is_plain(begin, end, from.floor)) ||
        is_slope(from, to)) {
        return true;
    }
    const bool diagonal = begin.x != end.x && begin.z != end.z;
    const float path = cell_m_ * (diagonal ? std::numbers::sqrt2_v<float> : 1.0F);
    const int ticks =
        static_cast<int>(std::ceil(path / (kShareOfRadius * std::max(limits_.radius, 0.01F))));
    if (to.floor - from.floor > static_cast<float>(ticks) * ledge_m_ + steepest_ * path ||
        is_wall(from, to)) {
        return false;  // higher than any stair: no need to try
    }
    motion::CharacterState state;
    state.position = Vec3(begin.x, from.floor + half_height_, begin.z);
    state.velocity = Vec3(end.x - begin.x, 0.0F, end.z - begin.z) / path;
    state.grounded = true;
    motion::InputCommand command;
    command.move_x = full_move(end.x - begin.x);
    command.move_z = full_move(end.z - begin.z);
    const float a_tick = path / static_cast<float>(ticks);
    const auto off_m = [&] {
        return elementary::hypot(state.position.x() - end.x, state.position.z() - end.z);
    };
    for (int left = ticks; left > 0 && state.grounded; --left) {
        // Too far behind: neither walking on nor a push out of a box brings it there in time.
        if (off_m() > static_cast<float>(left) * a_tick + kOffMiddle * cell_m_ + limits_.radius) {
            return false;
        }
        const Vec3 before = state.position;
        const Vec3 velocity = state.velocity;
        state = motion::apply_input(state, command, limits_, world_, a_tick);
        if (state.position == before && state.velocity == velocity) {
            break;  // held for good
        }
    }
    const float off_y = state.position.y() - half_height_ - to.floor;
    return state.grounded && std::abs(off_y) <= off_floor_m_ && off_m() <= kOffMiddle * cell_m_;
}

/// Bounds of all that a capsule may touch on a straight walk from place to place.
Aabb StepTrial::around_step(const Foothold& from, const Foothold& to) const {
    const float reach = limits_.radius + kClear;
    const float low = std::min(from.floor, to.floor);
    const float top =
        std::max(from.floor, to.floor) + 2.0F * half_height_ + limits_.step_up + kClear;
    return {Vec3(std::min(from.at.x, to.at.x) - reach,
                 low - kLevel,
                 std::min(from.at.z, to.at.z) - reach),
            Vec3(std::max(from.at.x, to.at.x) + reach, top, std::max(from.at.z, to.at.z) + reach)};
}

/// Whether surfaces have nothing above that height there, however high: a capsule below one comes
/// up out of it.
bool StepTrial::surfaces_below(const Aabb& around, float height) const {
    bool below = true;
    for (const motion::PlacedSurface& s : world_.surfaces()) {
        const Vec3 middle = 0.5F * (around.lower + around.upper);
        const Vec3 half = 0.5F * (around.upper - around.lower);
        // It is turned about y: a square holds the rectangle, however that lies.
        const float side = Vec2(half.x(), half.z()).norm();
        const Vec3 reach(side, kEverywhere_m, side);
        const Vec3 local = s.to_local(middle);
        s.surface().for_each_near({local - reach, local + reach}, [&](const FacedTriangle& t) {
            for (const Vec3& corner : t.corner) {
                below = below && s.to_world(corner).y() <= height;
            }
        });
    }
    return below;
}

/// Whether a character that walks there straight at that height has level ground all along, and
/// touches nothing else. Most steps near things are such, and this is cheaper than a trial.
bool StepTrial::is_plain(Spot begin, Spot end, float floor) const {
    const float reach = limits_.radius + kClear;
    const Aabb around = around_step({begin, floor}, {end, floor});
    bool carried = std::abs(floor - world_.ground_height()) <= kLevel;
    bool clear = true;
    world_.for_each_near(around, [&](std::uint32_t box) {
        if (world_.box_bounds(box).upper.y() <= floor + kLevel) {
            carried = carried || is_level_under(box, begin, end);
        } else {
            clear = clear && plans_[box].least_distance(begin, end) > reach;
        }
    });
    return carried && clear && surfaces_below(around, floor + kLevel);
}

/// The same on the face of a box that is no steeper than what carries.
bool StepTrial::is_slope(const Foothold& from, const Foothold& to) const {
    const float low = std::min(from.floor, to.floor);
    if (!(low > world_.ground_height() + kLevel)) {
        return false;
    }
    const float reach = limits_.radius + kClear;
    const Aabb around = around_step(from, to);
    bool carried = false;
    bool clear = true;
    world_.for_each_near(around, [&](std::uint32_t box) {
        if (is_on_slope(box, from) && is_on_slope(box, to)) {
            carried = true;
        } else if (world_.box_bounds(box).upper.y() > low) {
            clear = clear && plans_[box].least_distance(from.at, to.at) > reach;
        }
    });
    return carried && clear && surfaces_below(around, low);
}

/// Whether a capsule rests there on the upper face of a box.
bool StepTrial::is_on_slope(std::uint32_t box, const Foothold& at) const {
    const Mat3& axes = world_.box_axes(box);
    int upper = 0;
    axes.row(1).cwiseAbs().maxCoeff(&upper);
    if (std::abs(axes(1, upper)) < limits_.max_slope_cos + kSlopeMargin) {
        return false;
    }
    const motion::StaticBox& b = world_.box(box);
    const Vec3 middle(at.at.x, at.floor + limits_.radius, at.at.z);
    Vec3 local = (axes.transpose() * (middle - b.centre)).cwiseAbs();
    const bool above = (middle - b.centre).dot(axes.col(upper)) * axes(1, upper) > 0.0F;
    const float off = local[upper] - b.half_extents[upper] - limits_.radius;
    local[upper] = 0.0F;
    return above && std::abs(off) <= 2.0F * kLevel &&
           (local.array() <= b.half_extents.array()).all();
}

bool StepTrial::is_upright(std::uint32_t box) const {
    return std::abs(world_.box_axes(box)(1, 1)) > kUpright;
}

/// Whether both places lie over the top face of an upright box.
bool StepTrial::is_level_under(std::uint32_t box, Spot begin, Spot end) const {
    const motion::StaticBox& b = world_.box(box);
    const auto over = [&](Spot at) {
        const Vec3 local =
            world_.box_axes(box).transpose() * Vec3(at.x - b.centre.x(), 0.0F, at.z - b.centre.z());
        return std::abs(local.x()) <= b.half_extents.x() &&
               std::abs(local.z()) <= b.half_extents.z();
    };
    return is_upright(box) && over(begin) && over(end);
}

/// Whether no slope and no top of a box leads up there, or as near below it as a step may end.
bool StepTrial::is_wall(const Foothold& from, const Foothold& to) const {
    // On a rim the capsule may stand lower than the box's top, by its radius at most.
    const float most = ledge_m_ + 2.0F * limits_.radius;
    if (!(to.floor - from.floor > most)) {
        return false;
    }
    const Aabb around = around_trial(from, to);
    bool level = true;
    std::array<float, kMostTops> tops{to.floor};
    std::size_t count = 1;
    world_.for_each_near(around, [&](std::uint32_t box) {
        level = level && is_upright(box) && count < tops.size();
        if (level) {
            tops[count++] = std::min(world_.box_bounds(box).upper.y(), to.floor);
        }
    });
    if (!level || !surfaces_below(around, from.floor)) {
        return false;
    }
    std::sort(tops.begin(), tops.begin() + static_cast<std::ptrdiff_t>(count));
    float reached = from.floor;
    for (std::size_t i = 0; i < count && !(tops[i] - reached > most); ++i) {
        reached = std::max(reached, tops[i]);
    }
    return to.floor - reached > most && (to.floor - reached > off_floor_m_ + limits_.radius ||
                                         is_in_box(to.at, reached + most, around));
}

/// Bounds of all that a capsule may touch on a trial that arrives: it is never farther from both
/// places together than walks() has it.
Aabb StepTrial::around_trial(const Foothold& from, const Foothold& to) const {
    const float path = Vec2(to.at.x - from.at.x, to.at.z - from.at.z).norm();
    const float more = kOffMiddle * cell_m_ + limits_.radius;
    const float aside = 0.5F * std::sqrt((2.0F * path + more) * more);
    const float reach = aside + limits_.radius + 10.0F * kClear;
    return {
        Vec3(
            std::min(from.at.x, to.at.x) - reach, from.floor, std::min(from.at.z, to.at.z) - reach),
        Vec3(std::max(from.at.x, to.at.x) + reach, to.floor, std::max(from.at.z, to.at.z) + reach)};
}

/// Whether a capsule is in a box wherever a step may end that arrives there, up to that height.
bool StepTrial::is_in_box(Spot at, float height, const Aabb& around) const {
    const float below = world_.ground_height() + 2.0F * half_height_;
    const float depth = kOffMiddle * cell_m_ - limits_.radius + kClear;
    bool found = false;
    world_.for_each_near(around, [&](std::uint32_t box) {
        const Aabb& bounds = world_.box_bounds(box);
        found = found || (is_upright(box) && bounds.lower.y() < below &&
                          bounds.upper.y() > height && plans_[box].depth(at) > depth);
    });
    return found;
}

}  // namespace zoned::ai::pathfinding
