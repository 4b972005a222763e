#include "server/ai/steering/terrain_walk.h"

#include "server/ai/steering/desired_velocity.h"
#include "shared/motion/capsule_sweep.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

/// A character whose velocity differs from its desired velocity by more than this share has hit
/// something.
constexpr float kMetShare = 0.01F;
constexpr int kMostPieces = 32;
/// A character this near to the height of the ground plane stands on it, m.
constexpr float kOnPlain_m = 0.005F;
/// A look ahead is made of pieces of this length, m, and of shorter ones where something is near.
/// Something holds a character up that covers less than this share of a piece.
constexpr float kLookAhead_m = 4.0F;
constexpr float kNearPiece_m = 0.2F;
constexpr float kHeldUpShare = 0.1F;
/// Beyond this nothing is looked for, m: no zone is so large, and a goal may be anywhere.
constexpr float kFarthestLook_m = 4000.0F;
/// The greatest rise or drop of the ground over 1 m of walk, m.
constexpr float kSteepest = 1.2F;
/// The greatest rise at once, m: a surface above it is a roof.
constexpr float kMostRise = 2.5F;

/// Navmesh layers are this near to the surface that carries, m. A character higher above a layer
/// stands on another one.
constexpr float kFloorOff = 0.5F;
constexpr float kOnAnotherFloor = 1.0F;

/// Whether a walk over the plain meets nothing, so that it need not be tried.
bool is_open(const Vec3& from,
             const Vec3& way,
             const motion::CharacterLimits& limits,
             const motion::StaticGeometry& statics,
             Tick now) {
    const float height = limits.radius + limits.half_segment;
    if (std::abs(from.y() - statics.ground_height() - height) > kOnPlain_m) {
        return false;
    }
    const Vec3 to = from + way;
    const Aabb area = Aabb{from.cwiseMin(to), from.cwiseMax(to)}.grown(height + limits.step_up +
                                                                       limits.step_down);
    const auto& surfaces = statics.surfaces();
    bool open = std::none_of(surfaces.begin(), surfaces.end(), [&](const auto& placed) {
        return placed.bounds().overlaps(area);
    });
    if (open) {
        statics.for_each_near(area, now, [&open](std::uint32_t /*box*/) { open = false; });
    }
    return open;
}

/// Puts a character down from `above` by `drop` at most. `free`: whether it had room there.
Vec3 put_down(const motion::StaticGeometry& statics,
              const motion::CharacterLimits& limits,
              const Vec3& above,
              float drop,
              Tick tick,
              bool& free) {
    const Aabb area = Aabb{above - Vec3(0.0F, drop, 0.0F), above}.grown(2.0F * limits.radius);
    const motion::CapsuleSweep sweep(statics, {limits.radius, limits.half_segment}, area, tick);
    const Vec3 begin = sweep.parted(above);
    const motion::SweepHit hit = sweep.sweep_down(begin, drop, [&](const motion::SweepHit& h) {
        return h.normal.y() >= limits.max_slope_cos;
    });
    free = (begin - above).norm() < kFloorOff && hit.hit;
    Vec3 place = begin - Vec3(0.0F, hit.fraction * drop, 0.0F);
    if (hit.ground_plane) {
        place.y() = sweep.floor_height();
    }
    return place;
}

}  // namespace

Vec2 wanted_by(const motion::InputCommand& command, const motion::CharacterLimits& limits) {
    const Vec2 move(static_cast<float>(command.move_x) / kFullMove,
                    static_cast<float>(command.move_z) / kFullMove);
    const bool sprints = (command.buttons & motion::kButtonSprint) != 0;
    return move / std::max(1.0F, move.norm()) *
           (limits.speed * (sprints ? limits.sprint_factor : 1.0F));
}

Walked walked(const motion::CharacterState& from,
              const motion::InputCommand& command,
              const motion::CharacterLimits& limits,
              const motion::StaticGeometry& statics,
              float time_s,
              Tick now) {
    const Vec2 wanted = wanted_by(command, limits);
    const Vec3 way(wanted.x() * time_s, 0.0F, wanted.y() * time_s);
    const bool at_once =
        (wanted - over_ground(from.velocity)).norm() <= limits.acceleration * time_s;
    if (at_once && is_open(from.position, way, limits, statics, now)) {
        return {{from.position + way, Vec3(wanted.x(), 0.0F, wanted.y()), command.yaw, true}};
    }
    Walked out{motion::apply_input(from, command, limits, statics, time_s, now)};
    const float off = (over_ground(out.state.velocity) - wanted).norm();
    if (out.state.grounded && off <= kMetShare * wanted.norm()) {
        return out;
    }
    const float piece_m = std::max(limits.step_down, 0.1F) / kSteepest;
    const auto pieces =
        std::clamp(static_cast<int>(std::ceil(wanted.norm() * time_s / piece_m)), 2, kMostPieces);
    out = {from, false};
    for (int k = 0; k < pieces && out.state.grounded; ++k) {
        out.state = motion::apply_input(
            out.state, command, limits, statics, time_s / static_cast<float>(pieces), now);
    }
    return out;
}

LookAhead look_ahead(const Vec3& from,
                     const Vec2& direction,
                     float length,
                     const motion::CharacterLimits& limits,
                     const motion::StaticGeometry& statics,
                     Tick now,
                     float aside_m) {
    motion::InputCommand command;
    command.move_x = static_cast<std::int8_t>(std::lround(kFullMove * direction.x()));
    command.move_z = static_cast<std::int8_t>(std::lround(kFullMove * direction.y()));
    const Vec2 wanted = wanted_by(command, limits);
    const float speed = wanted.norm();
    if (!(speed > 0.0F)) {
        return {0.0F, 0.0F, from};
    }
    const Vec2 heading = wanted / speed;
    motion::CharacterState state{from, Vec3(wanted.x(), 0.0F, wanted.y()), 0, true};
    float done = 0.0F;
    float aside = 0.0F;
    while (done < std::min(length, kFarthestLook_m)) {
        float piece = std::min(kLookAhead_m, length - done);
        Walked to = walked(state, command, limits, statics, piece / speed, now);
        if (!to.free) {
            piece = std::min(kNearPiece_m, length - done);
            to = walked(state, command, limits, statics, piece / speed, now);
        }
        const Vec2 way = over_ground(to.state.position - from);
        aside = std::abs(way.x() * heading.y() - way.y() * heading.x());
        const float ahead = to.free ? piece : way.dot(heading) - done;
        if (ahead < kHeldUpShare * piece || aside > aside_m) {
            return {std::clamp(done + ahead, 0.0F, length), aside, to.state.position};
        }
        state = to.state;
        done += ahead;
    }
    return {length, aside, state.position};
}

Vec3 standing_at(const motion::StaticGeometry& statics,
                 const motion::CharacterLimits& limits,
                 const Vec3& before,
                 const Vec2& at,
                 float floor,
                 Tick tick) {
    const float way = (at - Vec2(before.x(), before.z())).norm();
    const float rise = std::min(kSteepest * way + limits.step_up, kMostRise);
    const float drop = rise + kSteepest * way + limits.step_down;
    bool free = false;
    const Vec3 above(at.x(), before.y() + rise, at.y());
    const Vec3 place = put_down(statics, limits, above, drop, tick, free);
    const float middle = floor + limits.radius + limits.half_segment;
    if (!(place.y() > middle + kOnAnotherFloor)) {
        return place;
    }
    // The surface found is a bridge over the floor, unless there is no room below.
    const Vec3 below(at.x(), middle + kFloorOff, at.y());
    const Vec3 under =
        put_down(statics, limits, below, 2.0F * kFloorOff + limits.step_down, tick, free);
    return free ? under : place;
}

}  // namespace zoned::ai
