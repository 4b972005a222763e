// types: the aliases of Eigen's vectors and quaternions used everywhere. SI units, right-handed
// coordinates, y up.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace zoned {

using Vec2 = Eigen::Vector2f;
using Vec2d = Eigen::Vector2d;
using Vec3 = Eigen::Vector3f;
using Vec3d = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3f;
/// Unit quaternion, Hamilton convention, rotates body coordinates into world coordinates.
/// Not over-aligned: columns and messages stay packed.
using Quat = Eigen::Quaternion<float, Eigen::DontAlign>;

/// Standard gravity as the scenes use it, m/s2.
inline constexpr float kGravity = 9.81F;

}  // namespace zoned
