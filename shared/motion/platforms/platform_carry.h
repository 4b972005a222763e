// PlatformCarry: what moving platforms do to a character in one tick: they carry, push and let
// through.
#pragma once

#include "shared/motion/apply_input.h"
#include "shared/motion/capsule_sweep.h"

namespace zoned::motion {

/// A vector without its vertical part.
inline Vec3 horizontal(const Vec3& v) {
    return {v.x(), 0.0F, v.z()};
}

struct PlatformCarry {
    bool near = false;             ///< false: no platform is near, and nothing below says anything
    Vec3 position = Vec3::Zero();  ///< of the character, carried and pushed, m
    /// Velocity of the platform that it stands on, in the tick before and in this one, m/s; zero
    /// where it stands on none.
    Vec3 before = Vec3::Zero();
    Vec3 now = Vec3::Zero();
    Vec3 rest = Vec3::Zero();  ///< horizontal part of the carrying that an obstacle withheld, m
    /// Of a character in the air: horizontal velocity of the platform that it would come down on.
    Vec3 below = Vec3::Zero();
    PassedPlatforms passed;  ///< that let it through
};

/// From the tick before `tick` to `tick`:
/// - A character on the ground moves with the platform that it stands on. Rounding does not add up
///   within a kilometre of the origin (kPlatformStep_m).
/// - A platform that moves into a character pushes it along its surface's normal. Where something
///   fixed is behind the character, the platform lets it through instead: it is no obstacle for the
///   character until the two are apart.
/// Platforms are followed in pieces of half a radius, so that none passes over a character.
PlatformCarry carry_by_platforms(const CharacterState& from,
                                 const CharacterLimits& limits,
                                 const StaticGeometry& world,
                                 float dt,
                                 Tick tick);

/// The velocity of a platform in the tick that ends at `tick`, m/s.
Vec3 platform_velocity(const StaticGeometry& world, std::uint32_t platform, float dt, Tick tick);

/// Whether a platform may move a character that stands still there: one that moves or has just
/// stopped touches it, or it is inside one.
bool moved_by_platform(const Vec3& position,
                       const CharacterLimits& limits,
                       const StaticGeometry& world,
                       Tick tick);

}  // namespace zoned::motion
