// RigidHull: the rigid equivalent of a soft body: mass, motion and inertia; momentum is the same.
#pragma once

#include "server/physics/shapes/shape.h"
#include "shared/core/result.h"
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

/// Moments that vanish (nodes in one line) are raised to that of a ball of the thickness: only the
/// spin about such a line is not carried over.
RigidHull rigid_hull_of(const SoftBody& body);

/// The body that moves on in place of the nodes: the convex hull of the outermost of them, each as
/// large as the thickness, so that it rests where they rested; mass, tensor and motion are the
/// hull's, friction and drag are the material's. Its orientation is that of the tensor's principal
/// axes. Fails where the mass or the tensor is none that a rigid body may have.
core::Result<BodyDef> rigid_body_of(const SoftBody& body);

/// Moves the body as if it had been rigid since `hull` was taken: turned by `turn`, centre of mass
/// at `position`, with these velocities.
void place_rigid(SoftBody& body,
                 const RigidHull& hull,
                 const Vec3& position,
                 const Quat& turn,
                 const Vec3& velocity,
                 const Vec3& angular_velocity);

}  // namespace zoned::physics::soft
