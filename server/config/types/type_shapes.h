// type_shapes: turns the hull or compound of a type in the config into a shape of the physics.
#pragma once

#include "server/physics/shapes/shape.h"
#include "shared/core/result.h"
#include "shared/math/aabb.h"

namespace zoned::proto::config {
class Type;
}  // namespace zoned::proto::config

namespace zoned::config {

/// A shape that more than a few numbers describe, about its centre of mass and along its principal
/// axes.
struct Solid {
    physics::Shape shape;
    Quat stands = Quat::Identity();  ///< rotates it to its orientation in the config
    Aabb standing;                   ///< its box in that orientation, about the centre of mass, m
    Vec3 centre = Vec3::Zero();      ///< centre of mass as the config has it, m
    physics::Shape outer;            ///< of a compound: one hull around it
    float outer_cut_m = 0.0F;        ///< how far parts stand out of that, m
    float radius = 0.0F;             ///< of the sphere about the centre of mass that holds it, m
};

/// Shape of a type with a hull or a compound. Fails with the reason where points lie in a plane,
/// sizes are out of range or a part has no shape.
core::Result<Solid> build_solid(const proto::config::Type& type);

/// The tensor of inertia that a type gives, along the axes of its body, kg m2; zero where it gives
/// none. `stands`: how the body is turned as the config has it.
Mat3 given_inertia(const proto::config::Type& type, const Quat& stands);

}  // namespace zoned::config
