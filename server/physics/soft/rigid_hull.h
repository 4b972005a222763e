// RigidHull: what a soft body is as a rigid one: mass, motion, inertia; momentum is the same.
#pragma once

#include "shared/math/types.h"

namespace zoned::physics::soft {

struct SoftBody;

struct RigidHull {
    float mass = 0.0F;                     ///< kg
    Vec3 position = Vec3::Zero();          ///< centre of mass, m
    Vec3 velocity = Vec3::Zero();          ///< m/s
    Vec3 angular_velocity = Vec3::Zero();  ///< rad/s: inertia times it is the angular momentum
    Mat3 inertia = Mat3::Identity();       ///< about the centre of mass, world axes, kg m2
    Vec3 half_extents = Vec3::Zero();      ///< of the box about the centre of mass, world axes, m
};

/// Moments that vanish (nodes in one line or point) are raised to a millionth of the largest one.
RigidHull rigid_hull_of(const SoftBody& body);

/// Moves the body as if it had been rigid since `hull` was taken: turned by `turn`, centre of mass
/// at `position`, with these velocities.
void place_rigid(SoftBody& body,
                 const RigidHull& hull,
                 const Vec3& position,
                 const Quat& turn,
                 const Vec3& velocity,
                 const Vec3& angular_velocity);

}  // namespace zoned::physics::soft
