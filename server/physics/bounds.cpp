#include "server/physics/bounds.h"

namespace zoned::physics {

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
        case ShapeKind::kPlane:
            break;
    }
    return {position - reach, position + reach};
}

}  // namespace zoned::physics
