#include "server/physics/shapes/shape.h"

namespace zoned::physics {

Shape Shape::sphere(float radius) {
    Shape shape;
    shape.kind = ShapeKind::kSphere;
    shape.radius = radius;
    return shape;
}

Shape Shape::box(const Vec3& half_extents) {
    Shape shape;
    shape.kind = ShapeKind::kBox;
    shape.half_extents = half_extents;
    return shape;
}

Shape Shape::capsule(float radius, float half_segment) {
    Shape shape;
    shape.kind = ShapeKind::kCapsule;
    shape.radius = radius;
    shape.half_segment = half_segment;
    return shape;
}

Shape Shape::plane() {
    Shape shape;
    shape.kind = ShapeKind::kPlane;
    return shape;
}

}  // namespace zoned::physics
