// Ranges: the numbers that the engine accepts because float arithmetic can carry them.
#pragma once

#include "shared/math/types.h"

namespace zoned::physics {

inline constexpr float kMaxCoordinate = 1.0e6F;  ///< m from the zone origin along each axis
inline constexpr float kMaxSpeed = 1.0e4F;       ///< m/s
inline constexpr float kMaxSpin = 1.0e4F;        ///< rad/s
inline constexpr float kMaxForce = 1.0e15F;      ///< N and N m
inline constexpr float kMinSize = 1.0e-3F;       ///< m
inline constexpr float kMaxSize = 1.0e5F;        ///< m
inline constexpr float kMinMass = 1.0e-6F;       ///< kg
inline constexpr float kMaxMass = 1.0e9F;        ///< kg
inline constexpr float kMinMoment = 1.0e-15F;    ///< kg m2: its inverse is still a float
inline constexpr float kMaxMoment = 1.0e21F;     ///< kg m2
inline constexpr float kMinDensity = 1.0e-3F;    ///< kg/m3
inline constexpr float kMaxDensity = 1.0e6F;     ///< kg/m3

/// Written so that NaN fails: every comparison with it is false.
inline bool within(float value, float lower, float upper) {
    return value >= lower && value <= upper;
}

/// Finite and within the limits above; false for NaN.
bool fit_position(const Vec3& position);
bool fit_force(const Vec3& force, const Vec3& torque);
bool fit_motor(float speed, float most);
bool fit_velocity(const Vec3& velocity, const Vec3& angular_velocity);
/// Length within 1 % of one.
bool fit_orientation(const Quat& orientation);

}  // namespace zoned::physics
