// GJK: the closest points of two convex sets of corners.
#pragma once

#include "server/physics/shapes/convex/hull_view.h"

namespace zoned::physics {

struct Closest {
    double distance = 0.0;       ///< m; 0 when they overlap
    Vec3d on_a = Vec3d::Zero();  ///< nearest points; equal when the hulls overlap
    Vec3d on_b = Vec3d::Zero();
    Vec3d normal = Vec3d::UnitY();  ///< unit, from a to b; means nothing when they overlap
    bool overlap = false;
};

/// Distance of the convex hulls of two sets of points, both in the same frame (Gilbert, Johnson,
/// Keerthi, "A fast procedure for computing the distance between complex objects", IEEE J. Robotics
/// Autom. 4(2), 1988). Corners are floats, the simplex is kept in doubles, so that the result is
/// exact to about 1e-7 of the size of the sets. `guess` is any direction from a to b.
Closest closest_points(const PointsView& a, const PointsView& b, const Vec3& guess);

}  // namespace zoned::physics
