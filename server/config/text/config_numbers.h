// config_numbers: converts doubles and degrees of configs to the stages' types and radians, and
// numbers that follow from others where a config does not set them.
#pragma once

#include "shared/core/elementary/elementary.h"
#include "shared/math/types.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace zoned::config {

inline constexpr double kRadians = std::numbers::pi / 180.0;  ///< in a degree

inline float narrow(double value) {
    return static_cast<float>(value);
}

/// A turn about a unit vector.
inline Eigen::Quaterniond turn_rad(double angle_rad, const Vec3d& axis) {
    const auto [sine, cosine] = elementary::sincos(0.5 * angle_rad);
    return {cosine, sine * axis.x(), sine * axis.y(), sine * axis.z()};
}

inline Eigen::Quaterniond turn(double degrees, const Vec3d& axis) {
    return turn_rad(degrees * kRadians, axis);
}

/// By yaw about y, then pitch about its own x, then roll about its own z, degrees.
inline Eigen::Quaterniond turn(double yaw_deg, double pitch_deg, double roll_deg) {
    return turn(yaw_deg, Vec3d::UnitY()) * turn(pitch_deg, Vec3d::UnitX()) *
           turn(roll_deg, Vec3d::UnitZ());
}

/// Ticks after which a client gets a datagram at the latest, where replication.silence_ticks is not
/// set: half a second, but no more than at the usual rate.
inline std::uint32_t usual_silence_ticks(double tick_rate_hz) {
    return static_cast<std::uint32_t>(std::clamp(std::floor(0.5 * tick_rate_hz), 1.0, 12.0));
}

inline Quat narrow(const Eigen::Quaterniond& turned) {
    return Quat(turned.cast<float>()).normalized();
}

}  // namespace zoned::config
