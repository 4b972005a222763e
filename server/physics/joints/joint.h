// JointDef: a joint between two bodies, as a scene takes it.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <cstdint>
#include <limits>
#include <string>

namespace zoned::physics {

enum class JointKind : std::uint8_t {
    kBall,      ///< a point of a stays on a point of b
    kHinge,     ///< a ball joint whose bodies turn about one axis only
    kSlider,    ///< b moves along one axis of a and does not turn against it
    kFixed,     ///< b stays where it is on a
    kDistance,  ///< two points keep their distance
    kSpring,    ///< a spring and damper between two points
};

struct JointDef {
    JointKind kind = JointKind::kBall;
    BodyId a;                      ///< none: the world
    BodyId b;                      ///< dynamic or kinematic
    Vec3 anchor = Vec3::Zero();    ///< world point, at the bodies' present poses, m
    Vec3 anchor_b = Vec3::Zero();  ///< distance and spring: the point on b; `anchor` is on a
    /// Hinge and slider: of both bodies; ball: of b, which cone and twist are about. World, any
    /// length but zero.
    Vec3 axis = Vec3::UnitY();
    Vec3 cone_axis = Vec3::Zero();  ///< ball: middle of the cone, fixed to a, world; zero: `axis`
    /// Ball: the axis leaves the middle of the cone by no more than this, rad; 0: it may go
    /// anywhere.
    float cone_rad = 0.0F;
    float length_m = -1.0F;  ///< distance and spring: rest length; negative: as it is now
    float spring_hz = 2.0F;  ///< spring: natural frequency on the bodies' reduced mass
    float spring_damping_ratio = 0.5F;  ///< spring: 1 is critical
    /// Hinge: angle in rad from the present pose; slider: shift in m; ball: twist of b about its
    /// axis in rad, within a cone alone. lower <= upper.
    bool limited = false;
    float lower = 0.0F;
    float upper = 0.0F;
    /// Hinge: rad/s, at most motor_max N m; slider: m/s, N; ball: friction of motor_max N m.
    bool motor = false;
    float motor_speed = 0.0F;
    float motor_max = 0.0F;
    /// The joint is gone after a step in which it pulled harder than this, N (its torques, N m, are
    /// not counted).
    float break_force_n = std::numeric_limits<float>::infinity();
    bool collide = false;    ///< a and b collide with each other too
    std::uint32_t user = 0;  ///< the caller's tag
};

/// The widest cone within which a ball joint may limit its twist, rad: where b points straight back
/// its twist is anything.
inline constexpr float kWidestTwistCone = 2.618F;
/// The narrowest cone, rad; a hinge or fixed joint holds an axis in its place.
inline constexpr float kNarrowestCone = 0.0174F;

/// A joint that broke in the last step.
struct JointBreak {
    JointId joint;
    BodyId a, b;
    std::uint32_t user = 0;
    float force_n = 0.0F;
};

/// Empty when the definition is fit for a scene, otherwise the reason.
std::string why_unfit(const JointDef& def);

}  // namespace zoned::physics
