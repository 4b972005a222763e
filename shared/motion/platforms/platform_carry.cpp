#include "shared/motion/platforms/platform_carry.h"

#include <algorithm>
#include <cmath>

namespace zoned::motion {

namespace {

/// A character stands on what is so near below it: it keeps a skin of air, m.
constexpr float kStands = 3.0F * kSkin;
constexpr int kMostPieces = 64;
constexpr int kPushPasses = 4;
constexpr int kPushSlides = 3;  ///< obstacles that a push may be turned aside by
constexpr float kLeastGravity = 1e-3F;

Capsule capsule_of(const CharacterLimits& limits) {
    return {limits.radius, limits.half_segment};
}

/// How far below a character in the air a platform still moves along with it: as high as it jumps.
float jump_height(const CharacterLimits& limits) {
    return limits.jump_speed * limits.jump_speed / (2.0F * std::max(limits.gravity, kLeastGravity));
}

/// The capsule at `position`, with `below` under it.
Aabb around(const Vec3& position, const CharacterLimits& limits, float below) {
    const Vec3 reach = Vec3(limits.radius, limits.radius + limits.half_segment, limits.radius) +
                       Vec3::Constant(2.0F * kSkin);
    return {position - reach - Vec3(0.0F, below, 0.0F), position + reach};
}

/// One character during one tick, among platforms.
class Passenger {
  public:
    Passenger(const CharacterState& from,
              const CharacterLimits& limits,
              const StaticGeometry& world,
              float dt,
              Tick tick)
        : from_(from),
          limits_(limits),
          world_(world),
          dt_(dt),
          tick_(tick),
          below_(from.grounded ? kStands : jump_height(limits)) {
        none_.all = true;
        out_.position = from.position;
        world.for_each_platform_near(around(from.position, limits, below_), [&](std::uint32_t p) {
            out_.near = true;
            fastest_m_ = std::max(fastest_m_, world.platform_move(p, tick).norm());
            // A platform that overlapped the character a tick ago let it through.
            if (gap(from.position, world.platform_box(p, tick - 1), p).distance < limits.radius) {
                out_.passed.add(p);
            }
        });
    }

    PlatformCarry carried() {
        if (!out_.near) {
            return out_;
        }
        const std::uint32_t under = platform_below();
        Vec3 way = Vec3::Zero();
        if (under != kNoPlatform) {
            const Vec3 velocity = platform_velocity(world_, under, dt_, tick_);
            if (from_.grounded) {
                way = world_.platform_move(under, tick_);
                out_.before = platform_velocity(world_, under, dt_, tick_ - 1);
                out_.now = velocity;
            } else {
                out_.below = horizontal(velocity);
            }
        }
        follow(way);
        return out_;
    }

  private:
    [[nodiscard]] SegmentBoxDistance gap(const Vec3& position,
                                         const StaticBox& box,
                                         std::uint32_t platform) const {
        return distance_to(capsule_of(limits_), position, box, world_.platform_axes(platform));
    }

    /// The platform on which it stood a tick ago, or over which it was.
    [[nodiscard]] std::uint32_t platform_below() const {
        const Vec3 down(0.0F, -below_, 0.0F);
        const CapsuleSweep sweep(world_,
                                 capsule_of(limits_),
                                 {from_.position + down, from_.position},
                                 tick_ - 1,
                                 &out_.passed);
        return sweep.sweep(from_.position, down).platform;
    }

    /// Moves it along with all platforms, piece by piece. `way`: of the one that carries it.
    void follow(const Vec3& way) {
        const int pieces = std::clamp(
            static_cast<int>(std::ceil(fastest_m_ / (0.5F * limits_.radius))), 1, kMostPieces);
        const Vec3 start = from_.position;
        const Aabb area =
            Aabb{start, start}.grown(2.0F * fastest_m_ + 2.0F * limits_.radius + kSkin);
        const CapsuleSweep sweep(world_, capsule_of(limits_), area, tick_, &none_);
        const Aabb reached = around(start, limits_, 0.0F).grown(fastest_m_);
        Vec3 pushed = Vec3::Zero();
        Vec3 target = start;
        for (int piece = 1; piece <= pieces; ++piece) {
            const float share = static_cast<float>(piece) / static_cast<float>(pieces);
            target = start + (piece == pieces ? way : Vec3(share * way)) + pushed;
            const Vec3 move = target - out_.position;
            const SweepHit hit = sweep.sweep(out_.position, move);
            out_.position = hit.hit ? Vec3(out_.position + hit.fraction * move) : target;
            pushed += push_apart(share, reached, sweep);
        }
        const Vec3 withheld = start + way + pushed - out_.position;
        out_.rest = pushed.isZero(0.0F) && target == out_.position ? Vec3(Vec3::Zero())
                                                                   : horizontal(withheld);
    }

    /// A platform near, when it has come by `share` of its move.
    [[nodiscard]] StaticBox box_at(std::uint32_t platform, float share) const {
        StaticBox box = world_.platform_box(platform, tick_);
        if (share < 1.0F) {
            box.centre -= (1.0F - share) * world_.platform_move(platform, tick_);
        }
        return box;
    }

    /// Pushes it out of all platforms; those in which it stays let it through. Returns by how much.
    Vec3 push_apart(float share, const Aabb& reached, const CapsuleSweep& sweep) {
        const Vec3 begin = out_.position;
        bool overlaps = true;
        for (int pass = 0; pass < kPushPasses && overlaps; ++pass) {
            overlaps = false;
            world_.for_each_platform_near(reached, [&](std::uint32_t platform) {
                overlaps = (!out_.passed.has(platform) &&
                            push(platform, box_at(platform, share), sweep)) ||
                           overlaps;
            });
        }
        if (overlaps) {
            world_.for_each_platform_near(reached, [&](std::uint32_t platform) {
                if (!out_.passed.has(platform) &&
                    gap(out_.position, box_at(platform, share), platform).distance <
                        limits_.radius) {
                    out_.passed.add(platform);
                }
            });
        }
        return out_.position - begin;
    }

    /// Pushes it out of a platform, as far as nothing fixed is in the way; true: it overlapped it.
    bool push(std::uint32_t platform, const StaticBox& box, const CapsuleSweep& sweep) {
        const SegmentBoxDistance found = gap(out_.position, box, platform);
        if (found.distance >= limits_.radius + kLeastAir) {
            return false;
        }
        Vec3 rest = world_.platform_axes(platform) * found.normal *
                    (limits_.radius + 0.5F * kSkin - found.distance);
        for (int slide = 0; slide < kPushSlides && !rest.isZero(0.0F); ++slide) {
            const SweepHit hit = sweep.sweep(out_.position, rest);
            out_.position += hit.fraction * rest;
            if (!hit.hit) {
                break;
            }
            rest *= 1.0F - hit.fraction;
            rest -= hit.normal * hit.normal.dot(rest);
        }
        return true;
    }

    const CharacterState& from_;
    const CharacterLimits& limits_;
    const StaticGeometry& world_;
    float dt_;
    Tick tick_;
    float below_;             // m under the character in which a platform counts
    float fastest_m_ = 0.0F;  // longest move of a platform near
    PassedPlatforms none_;    // for sweeps in which platforms are no obstacles
    PlatformCarry out_;
};

}  // namespace

PlatformCarry carry_by_platforms(const CharacterState& from,
                                 const CharacterLimits& limits,
                                 const StaticGeometry& world,
                                 float dt,
                                 Tick tick) {
    return Passenger(from, limits, world, dt, tick).carried();
}

Vec3 platform_velocity(const StaticGeometry& world, std::uint32_t platform, float dt, Tick tick) {
    return world.platform_move(platform, tick) / dt;
}

bool moved_by_platform(const Vec3& position,
                       const CharacterLimits& limits,
                       const StaticGeometry& world,
                       Tick tick) {
    if (world.platforms().empty() || tick == kAllDoorsOpen) {
        return false;
    }
    // As far as a walker looks for ground.
    const Aabb area = around(position, limits, limits.step_down);
    bool moved = false;
    world.for_each_platform_near(area, [&](std::uint32_t platform) {
        const Vec3 now = world.platform_offset(platform, tick);
        const Vec3 before = world.platform_offset(platform, tick - 1);
        const StaticBox box = world.platform_box(platform, tick);
        const Vec3 half = world.platform_axes(platform).cwiseAbs() * box.half_extents;
        const Vec3 old = box.centre - (now - before);
        const bool moves = now != before || before != world.platform_offset(platform, tick - 2);
        const bool touches =
            Aabb{box.centre.cwiseMin(old) - half, box.centre.cwiseMax(old) + half}.overlaps(area);
        moved =
            moved || (touches && moves) ||
            overlaps(
                {limits.radius, limits.half_segment}, position, box, world.platform_axes(platform));
    });
    return moved;
}

}  // namespace zoned::motion
