#include "server/physics/shapes/compound/bounds.h"

#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/convex/hull.h"
#include "server/physics/shapes/heightfield.h"
#include "server/physics/shapes/mesh.h"

#include <algorithm>
#include <limits>

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

/// The box of a turned box.
Aabb turned_box(const Aabb& box, const Vec3& position, const Mat3& rotation) {
    const Vec3 centre = position + rotation * (0.5F * (box.lower + box.upper));
    const Vec3 reach = rotation.cwiseAbs() * (0.5F * (box.upper - box.lower));
    return {centre - reach, centre + reach};
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
        case ShapeKind::kMesh:
            return turned_box(mesh_of(shape).box(), position, rotation);
        case ShapeKind::kHeightfield:
            return turned_box(field_of(shape).box(), position, rotation);
        case ShapeKind::kCompound:
            return turned_box(compound_of(shape).tree().box(), position, rotation);
        case ShapeKind::kPlane:
            break;
    }
    return {position - reach, position + reach};
}

float inner_radius(const Shape& shape) {
    switch (shape.kind) {
        case ShapeKind::kSphere:
        case ShapeKind::kCapsule:
            return shape.radius;
        case ShapeKind::kBox:
            return shape.half_extents.minCoeff();
        case ShapeKind::kHull:
            return hull_of(shape).view().inner;
        case ShapeKind::kCompound: {
            float least = std::numeric_limits<float>::infinity();
            for (const Compound::CompoundChild& child : compound_of(shape).parts()) {
                least = std::min(least, inner_radius(child.part.shape));
            }
            return least;
        }
        default:
            return 0.0F;
    }
}

}  // namespace zoned::physics
