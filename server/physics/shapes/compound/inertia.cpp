#include "server/physics/shapes/compound/inertia.h"

#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/convex/hull.h"

#include <numbers>

namespace zoned::physics {

namespace {

constexpr float kPi = std::numbers::pi_v<float>;

/// A capsule is a cylinder of height 2h and two half balls. A half ball's centroid lies 3r/8 from
/// its flat face and its transverse moment about the flat face's centre is 2/5 m r2; the parallel
/// axis theorem (twice) gives m (2/5 r2 + h2 + 3/4 h r) about the capsule's centre.
Vec3 capsule_inertia(float r, float h, float mass) {
    const float cylinder_volume = 2.0F * kPi * r * r * h;
    const float ball_volume = 4.0F / 3.0F * kPi * r * r * r;
    const float cylinder = mass * cylinder_volume / (cylinder_volume + ball_volume);
    const float balls = mass - cylinder;
    const float along = cylinder * r * r / 2.0F + balls * 0.4F * r * r;
    const float across =
        cylinder * (r * r / 4.0F + h * h / 3.0F) + balls * (0.4F * r * r + h * h + 0.75F * h * r);
    return {across, along, across};
}

}  // namespace

float volume(const Shape& shape) {
    switch (shape.kind) {
        case ShapeKind::kSphere:
            return 4.0F / 3.0F * kPi * shape.radius * shape.radius * shape.radius;
        case ShapeKind::kBox:
            return 8.0F * shape.half_extents.prod();
        case ShapeKind::kCapsule:
            return kPi * shape.radius * shape.radius *
                   (2.0F * shape.half_segment + 4.0F / 3.0F * shape.radius);
        case ShapeKind::kHull:
            return hull_of(shape).volume();
        case ShapeKind::kCompound:
            return compound_of(shape).volume();
        case ShapeKind::kPlane:
        case ShapeKind::kMesh:
        case ShapeKind::kHeightfield:
            break;
    }
    return 0.0F;
}

float bounding_radius(const Shape& shape) {
    switch (shape.kind) {
        case ShapeKind::kSphere:
            return shape.radius;
        case ShapeKind::kBox:
            return shape.half_extents.norm();
        case ShapeKind::kCapsule:
            return shape.radius + shape.half_segment;
        case ShapeKind::kHull:
            return hull_of(shape).radius();
        case ShapeKind::kCompound:
            return compound_of(shape).radius();
        case ShapeKind::kPlane:
        case ShapeKind::kMesh:
        case ShapeKind::kHeightfield:
            break;
    }
    return 0.0F;
}

Vec3 principal_inertia(const Shape& shape, float mass) {
    switch (shape.kind) {
        case ShapeKind::kSphere:
            return Vec3::Constant(0.4F * mass * shape.radius * shape.radius);
        case ShapeKind::kBox: {
            const Vec3 s = shape.half_extents.cwiseAbs2();
            return mass / 3.0F * Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
        }
        case ShapeKind::kCapsule:
            return capsule_inertia(shape.radius, shape.half_segment, mass);
        case ShapeKind::kHull:
            return mass * hull_of(shape).moments_per_kg();
        case ShapeKind::kCompound:
            return mass * compound_of(shape).moments_per_kg();
        case ShapeKind::kPlane:
        case ShapeKind::kMesh:
        case ShapeKind::kHeightfield:
            break;
    }
    return Vec3::Zero();
}

}  // namespace zoned::physics
