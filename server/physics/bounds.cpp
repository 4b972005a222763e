#include "server/physics/bounds.h"

#include "server/physics/hull.h"

namespace zoned::physics {

namespace {

/// A corner's world coordinate along an axis is its distance along that row of the rotation.
Aabb hull_bounds(const PointsView& points, const Vec3& position, const Mat3& rotation) {
    Aabb box{position, position};
    for (int i = 0; i < 3; ++i) {
        const Vec3 axis = rotation.row(i).transpose();
        box.lower[i] += lowest(points, axis);
        box.upper[i] -= lowest(points, -axis);
    }
    return box;
}

}  // namespace

Aabb shape_bounds(const Shape& shape, const Vec3& position, const Mat3& rotation) {
    Vec3 reach = Vec3::Zero();
    switch (shape.kind) {
        case ShapeKind::kSphere:
            reach = Vec3::Constant(shape.radius);
            break;
        case ShapeKind::kBox:
            reach = rotation.cwiseAbs() * shape.half_extents;
            break;
        case ShapeKind::kCapsule:
            reach = rotation.col(1).cwiseAbs() * shape.half_segment + Vec3::Constant(shape.radius);
            break;
        case ShapeKind::kHull:
            return hull_bounds(hull_of(shape).view().points, position, rotation);
        case ShapeKind::kPlane:
            break;
    }
    return {position - reach, position + reach};
}

}  // namespace zoned::physics
