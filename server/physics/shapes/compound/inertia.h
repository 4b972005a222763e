// Inertia: volume, bounding radius and principal moments of inertia of shapes, in closed form.
#pragma once

#include "server/physics/shapes/shape.h"

namespace zoned::physics {

/// Volume in m3; 0 for planes and surfaces.
float volume(const Shape& shape);

/// Radius of the smallest sphere about the centre of mass that holds the shape, m; 0 for planes and
/// surfaces.
float bounding_radius(const Shape& shape);

/// Principal moments of inertia (diagonal in body axes) of a solid of uniform density, kg m2.
/// Zero for planes and surfaces.
Vec3 principal_inertia(const Shape& shape, float mass);

/// World tensor R diag(moments) R^T of principal moments (or of their inverses).
inline Mat3 rotated_tensor(const Mat3& rotation, const Vec3& moments) {
    return rotation * moments.asDiagonal() * rotation.transpose();
}

}  // namespace zoned::physics
