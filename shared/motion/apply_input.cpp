#include "shared/motion/apply_input.h"

#include "shared/core/elementary/elementary.h"
#include "shared/math/aabb.h"
#include "shared/motion/capsule_sweep.h"
#include "shared/motion/platforms/platform_carry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace zoned::motion {

namespace {

constexpr int kSlides = 6;  ///< obstacles that one tick's move may be turned aside by

/// Surfaces that a move has met; it may not go into any of them.
class Obstacles {
  public:
    /// Forgets the oldest where there are too many: the caller's number of slides is limited
    /// anyway.
    void add(const Vec3& normal) {
        // A seam between two boxes shows nearly the same surface twice.
        for (std::size_t i = 0; i < count_; ++i) {
            if (normals_[i].dot(normal) > 0.99F) {
                normals_[i] = normal;
                return;
            }
        }
        normals_[count_ % normals_.size()] = normal;
        count_ = std::min(count_ + 1, normals_.size());
    }

    [[nodiscard]] std::size_t count() const { return count_; }

    [[nodiscard]] Vec3 sum() const {
        Vec3 total = Vec3::Zero();
        for (std::size_t i = 0; i < count_; ++i) {
            total += normals_[i];
        }
        return total;
    }

    /// The part of `move` that goes into none of the surfaces: along one, along the crease of two,
    /// or nowhere.
    [[nodiscard]] Vec3 slid(const Vec3& move) const {
        if (free(move)) {
            return move;
        }
        for (std::size_t i = 0; i < count_; ++i) {
            const Vec3 along = move - normals_[i] * normals_[i].dot(move);
            if (normals_[i].dot(move) < 0.0F && free(along)) {
                return along;
            }
        }
        for (std::size_t i = 0; i < count_; ++i) {
            for (std::size_t j = i + 1; j < count_; ++j) {
                const Vec3 crease = normals_[i].cross(normals_[j]);
                const float squared = crease.squaredNorm();
                if (squared > 1e-6F) {
                    const Vec3 along = crease * (crease.dot(move) / squared);
                    if (free(along)) {
                        return along;
                    }
                }
            }
        }
        return Vec3::Zero();
    }

    /// The part of the horizontal `move` that, carried by ground of normal `ground`, goes into none
    /// of the surfaces.
    [[nodiscard]] Vec3 slid_on_ground(const Vec3& move, const Vec3& ground) const {
        // On the ground the vertical part is d.y = -(g.x d.x + g.z d.z) / g.y. Put into w . d >= 0,
        // this leaves a condition on the horizontal part alone, whose normal is
        // w - (w.y / g.y) g without its y.
        Obstacles horizontal;
        for (std::size_t i = 0; i < count_; ++i) {
            Vec3 normal = normals_[i] - ground * (normals_[i].y() / ground.y());
            normal.y() = 0.0F;
            const float length = normal.norm();
            if (length < 1e-3F) {
                return Vec3::Zero();
            }
            horizontal.add(normal / length);
        }
        return horizontal.slid(move).cwiseProduct(Vec3(1.0F, 0.0F, 1.0F));
    }

  private:
    [[nodiscard]] bool free(const Vec3& move) const {
        const float tolerance = 1e-4F * move.norm();
        for (std::size_t i = 0; i < count_; ++i) {
            if (normals_[i].dot(move) < -tolerance) {
                return false;
            }
        }
        return true;
    }

    std::array<Vec3, kSlides> normals_;
    std::size_t count_ = 0;
};

/// Velocity after `dt` of acceleration towards a wanted velocity, and the distance moved meanwhile.
struct Acceleration {
    Vec3 velocity;
    Vec3 way;
};

/// Exact: constant acceleration until the wanted velocity is reached, that velocity from then on.
Acceleration accelerate(const Vec3& velocity, const Vec3& wanted, float acceleration, float dt) {
    const Vec3 change = wanted - velocity;
    const float size = change.norm();
    if (size <= acceleration * dt) {
        const float time = acceleration > 0.0F ? size / acceleration : 0.0F;
        return {wanted, (velocity + wanted) * (0.5F * time) + wanted * (dt - time)};
    }
    const Vec3 next = velocity + change * (acceleration * dt / size);
    return {next, (velocity + next) * (0.5F * dt)};
}

Vec3 wanted_velocity(const InputCommand& command, const CharacterLimits& limits) {
    Vec3 direction(static_cast<float>(command.move_x) / 127.0F,
                   0.0F,
                   static_cast<float>(command.move_z) / 127.0F);
    const float length = direction.norm();
    if (length > 1.0F) {
        direction /= length;
    }
    const bool sprints = (command.buttons & kButtonSprint) != 0;
    return direction * (limits.speed * (sprints ? limits.sprint_factor : 1.0F));
}

/// One character during one tick.
class Mover {
  public:
    Mover(const CharacterState& from,
          const CharacterLimits& limits,
          const StaticGeometry& world,
          const Vec3& way,
          float dt,
          Tick tick,
          const PlatformCarry* carry)
        : limits_(limits),
          world_(world),
          dt_(dt),
          tick_(tick),
          carry_(carry),
          start_height_(from.position.y()),
          door_push_(world.doors().empty() ? 0.0F : limits.speed * dt),
          sweep_(world,
                 {limits.radius, limits.half_segment},
                 region_of(from.position, way),
                 tick,
                 passed_by(carry)),
          state_(from) {
        state_.position = sweep_.parted(from.position, door_push_);
    }

    /// Moves along the ground: `way` is a horizontal displacement, `velocity` the velocity at its
    /// end.
    void walk(Vec3 way, const Vec3& velocity) {
        Obstacles walls;
        Vec3 ground = Vec3::UnitY();
        Vec3 move = way;
        float lifted = 0.0F;
        for (int slide = 0; slide < kSlides && !move.isZero(0.0F); ++slide) {
            const SweepHit hit = sweep_.sweep(state_.position, move);
            advance(move * hit.fraction);
            if (!hit.hit) {
                break;
            }
            way *= 1.0F - hit.fraction;
            if (is_floor(hit)) {
                ground = hit.normal;
            } else if (is_ledge(hit) && lift(hit, lifted)) {
                ground = Vec3::UnitY();
            } else {
                walls.add(hit.normal);
            }
            move = walls.slid_on_ground(way, ground);
            move.y() = climb(move, ground);
        }
        state_.velocity = walls.slid_on_ground(velocity, ground);
        settle(lifted);
    }

    /// Moves through the air: the displacement `way` and `velocity` (at its end) are
    /// three-dimensional.
    void fall(Vec3 way, Vec3 velocity, bool wants_rest) {
        Obstacles surfaces;
        const Vec3 whole_path = way;
        const Vec3 whole_velocity = velocity;
        Vec3 rest = way;
        state_.grounded = false;
        for (int slide = 0; slide < kSlides && !way.isZero(0.0F); ++slide) {
            const SweepHit hit = sweep_.sweep(state_.position, way);
            advance(way * hit.fraction);
            if (!hit.hit) {
                break;
            }
            rest *= 1.0F - hit.fraction;
            if (velocity.y() <= 0.0F && carries(hit)) {
                walk(horizontal(way) * (1.0F - hit.fraction), horizontal(velocity));
                return;
            }
            surfaces.add(hit.normal);
            way = surfaces.slid(rest);
            velocity = surfaces.slid(whole_velocity);
        }
        state_.velocity = velocity;
        // Steep surfaces that together hold the character up carry it: no character falls for ever
        // in a gap between a rock and a wall.
        const bool held = whole_path.y() < 0.0F &&
                          start_height_ - state_.position.y() < 0.01F * -whole_path.y() &&
                          surfaces.count() >= 2 && surfaces.sum().y() > 0.1F;
        if (held) {
            state_.grounded = true;
            state_.velocity = wants_rest ? Vec3::Zero() : horizontal(velocity);
        }
    }

    [[nodiscard]] const CharacterState& state() const { return state_; }

  private:
    static const PassedPlatforms* passed_by(const PlatformCarry* carry) {
        return carry == nullptr ? nullptr : &carry->passed;
    }

    /// The vertical part of a move that follows the ground.
    static float climb(const Vec3& move, const Vec3& ground) {
        return 0.0F - (ground.x() * move.x() + ground.z() * move.z()) / ground.y();
    }

    /// Slides never lengthen a move, climbing a slope that carries lengthens it at most by this
    /// factor.
    [[nodiscard]] Aabb region_of(const Vec3& position, const Vec3& way) const {
        const float carried = std::clamp(limits_.max_slope_cos, 0.1F, 1.0F);
        const float reach =
            way.norm() / carried + limits_.step_up + limits_.step_down + 0.1F + door_push_;
        return Aabb{position, position}.grown(reach);
    }

    void advance(const Vec3& move) {
        state_.position += move;
        state_.position.y() = std::max(state_.position.y(), sweep_.floor_height());
    }

    [[nodiscard]] bool is_floor(const SweepHit& hit) const {
        return hit.normal.y() >= limits_.max_slope_cos;
    }

    /// The rim of walkable ground, low enough to step onto: the round bottom of the capsule touches
    /// it at the height radius (1 - normal.y) above its lowest point.
    [[nodiscard]] bool is_ledge(const SweepHit& hit) const {
        return hit.face_up >= limits_.max_slope_cos && hit.normal.y() >= 0.1F &&
               limits_.radius * (1.0F - hit.normal.y()) <= limits_.step_up;
    }

    [[nodiscard]] bool carries(const SweepHit& hit) const { return is_floor(hit) || is_ledge(hit); }

    /// Rises until the bottom clears the ledge; false, and no change, where there is no room.
    bool lift(const SweepHit& ledge, float& lifted) {
        const float height = (limits_.radius + kSkin) * (1.0F - ledge.normal.y()) + kSkin;
        if (lifted + height > limits_.step_up + 0.1F * limits_.radius) {
            return false;
        }
        const Vec3 up(0.0F, height, 0.0F);
        if (sweep_.sweep(state_.position, up).hit) {
            return false;
        }
        advance(up);
        lifted += height;
        return true;
    }

    /// Follows the ground down after a walk, or leaves it.
    void settle(float lifted) {
        const float drop = limits_.step_down + lifted + 2.0F * kSkin;
        const SweepHit hit = sweep_.sweep_down(
            state_.position, drop, [this](const SweepHit& h) { return carries(h); });
        state_.grounded = hit.hit && carries(hit);
        if (!state_.grounded) {
            advance(Vec3(0.0F, -std::min(hit.fraction * drop, lifted), 0.0F));
            state_.velocity.y() = carry_ == nullptr ? 0.0F : carry_->now.y();
            return;
        }
        advance(Vec3(0.0F, -hit.fraction * drop, 0.0F));
        if (hit.ground_plane) {
            state_.position.y() = sweep_.floor_height();
        }
        if (hit.platform != kNoPlatform) {
            const Vec3 moving = platform_velocity(world_, hit.platform, dt_, tick_);
            state_.velocity -= moving;
            follow_ground(hit);
            state_.velocity += moving;
        } else {
            follow_ground(hit);
        }
    }

    /// Gives the velocity the vertical speed of the ground underfoot.
    void follow_ground(const SweepHit& hit) {
        // The normal of a rim turns within centimetres: there the mean of the tick says more, but
        // no more than ground that carries could give.
        const bool rim = hit.face_up > hit.normal.y() + 0.001F;
        const float rate =
            rim ? (state_.position.y() - start_height_) / dt_ : climb(state_.velocity, hit.normal);
        const float cosine = std::clamp(limits_.max_slope_cos, 0.1F, 1.0F);
        const float steepest = state_.velocity.norm() * std::sqrt(1.0F - cosine * cosine) / cosine;
        state_.velocity.y() = std::clamp(rate, -steepest, steepest) + 0.0F;
    }

    const CharacterLimits& limits_;
    const StaticGeometry& world_;
    float dt_;
    Tick tick_;
    const PlatformCarry* carry_;  // null: no platform is near
    float start_height_;
    float door_push_;  // m, out of doors that shut on it
    CapsuleSweep sweep_;
    CharacterState state_;
};

/// As apply_input(), of a character that platforms (null: there are none near) have carried to
/// `begin`. Inlined, so that a world without platforms does not look for them again and again.
[[gnu::always_inline]] inline CharacterState moved(const CharacterState& begin,
                                                   const Vec3& wanted,
                                                   bool jumps,
                                                   const CharacterLimits& limits,
                                                   const StaticGeometry& world,
                                                   float dt,
                                                   Tick tick,
                                                   const PlatformCarry* carry) {
    Vec3 velocity = horizontal(begin.velocity);
    Vec3 goal = wanted;
    if (carry != nullptr) {
        velocity -= horizontal(carry->before);
        goal += carry->below;
    }
    if (begin.grounded && !jumps) {
        Acceleration run = accelerate(velocity, goal, limits.acceleration, dt);
        if (carry != nullptr) {
            run.way += carry->rest;
            run.velocity += horizontal(carry->now);
        }
        Mover mover(begin, limits, world, run.way, dt, tick, carry);
        mover.walk(run.way, run.velocity);
        return mover.state();
    }
    const float rise = jumps ? limits.jump_speed : begin.velocity.y();
    Acceleration flight = accelerate(velocity, goal, limits.air_acceleration, dt);
    // The exact parabola, so that the apex is at v^2 / 2g whatever the step.
    flight.way.y() = (rise - 0.5F * limits.gravity * dt) * dt;
    flight.velocity.y() = rise - limits.gravity * dt;
    if (carry != nullptr) {
        flight.way += carry->rest;
        flight.velocity += carry->now;
    }
    Mover mover(begin, limits, world, flight.way, dt, tick, carry);
    mover.fall(flight.way, flight.velocity, wanted.isZero(0.0F));
    return mover.state();
}

[[gnu::noinline]] CharacterState moved_among_platforms(const CharacterState& from,
                                                       CharacterState begin,
                                                       const Vec3& wanted,
                                                       bool jumps,
                                                       const CharacterLimits& limits,
                                                       const StaticGeometry& world,
                                                       float dt,
                                                       Tick tick) {
    const PlatformCarry carry = carry_by_platforms(from, limits, world, dt, tick);
    begin.position = carry.near ? carry.position : begin.position;
    return moved(begin, wanted, jumps, limits, world, dt, tick, carry.near ? &carry : nullptr);
}

}  // namespace

CharacterState apply_input(const CharacterState& from,
                           const InputCommand& command,
                           const CharacterLimits& limits,
                           const StaticGeometry& world,
                           float dt,
                           Tick tick) {
    const Vec3 wanted = wanted_velocity(command, limits);
    const bool jumps = from.grounded && (command.buttons & kButtonJump) != 0;
    const bool platforms = !world.platforms().empty() && tick != kAllDoorsOpen;
    CharacterState begin = from;
    begin.yaw = command.yaw;
    if (from.carried) {
        begin.position += from.velocity * dt;
        return begin;
    }
    if (from.grounded && !jumps && wanted.isZero(0.0F) && from.velocity.isZero(0.0F) &&
        !moved_by_door(from.position, limits, world, tick) &&
        (!platforms || !moved_by_platform(from.position, limits, world, tick))) {
        return begin;  // static ground carries on carrying
    }
    if (platforms) {
        return moved_among_platforms(from, begin, wanted, jumps, limits, world, dt, tick);
    }
    return moved(begin, wanted, jumps, limits, world, dt, tick, nullptr);
}

bool moved_by_door(const Vec3& position,
                   const CharacterLimits& limits,
                   const StaticGeometry& world,
                   Tick tick) {
    if (world.doors().empty() || tick == kAllDoorsOpen) {
        return false;
    }
    // As far as a walker looks for ground.
    const Vec3 reach(limits.radius + kSkin,
                     limits.radius + limits.half_segment + limits.step_down + kSkin,
                     limits.radius + kSkin);
    bool moved = false;
    world.for_each_door_near({position - reach, position + reach}, [&](std::uint32_t number) {
        const Door& door = world.doors()[number];
        const bool shut = world.shut_at(number, tick);
        moved =
            moved || shut != world.shut_at(number, tick - 1) ||
            (shut &&
             overlaps({limits.radius, limits.half_segment},
                      position,
                      door.box,
                      world.box_axes(static_cast<std::uint32_t>(world.boxes().size()) + number)));
    });
    return moved;
}

Quat orientation_from_yaw(std::uint16_t yaw) {
    // As a signed turn, so that the real part is never negative: one sign for each orientation.
    const double half = static_cast<std::int16_t>(yaw) * (std::numbers::pi / 65536.0);
    const auto [sine, cosine] = elementary::sincos(half);
    return {static_cast<float>(cosine), 0.0F, static_cast<float>(sine), 0.0F};
}

}  // namespace zoned::motion
