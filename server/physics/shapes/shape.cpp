#include "server/physics/shapes/shape.h"

#include "server/physics/shapes/compound.h"
#include "server/physics/shapes/heightfield.h"
#include "server/physics/shapes/hull.h"
#include "server/physics/shapes/mesh.h"

#include <utility>

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

Shape Shape::hull(std::shared_ptr<const ConvexHull> hull) {
    Shape shape;
    shape.kind = ShapeKind::kHull;
    shape.geometry = std::move(hull);
    return shape;
}

Shape Shape::mesh(std::shared_ptr<const TriangleMesh> mesh) {
    Shape shape;
    shape.kind = ShapeKind::kMesh;
    shape.geometry = std::move(mesh);
    return shape;
}

Shape Shape::heightfield(std::shared_ptr<const Heightfield> field) {
    Shape shape;
    shape.kind = ShapeKind::kHeightfield;
    shape.geometry = std::move(field);
    return shape;
}

Shape Shape::compound(std::shared_ptr<const Compound> compound) {
    Shape shape;
    shape.kind = ShapeKind::kCompound;
    shape.geometry = std::move(compound);
    return shape;
}

}  // namespace zoned::physics
