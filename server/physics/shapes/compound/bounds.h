// Bounds: the bounding boxes of placed shapes.
#pragma once

#include "server/physics/shapes/shape.h"
#include "shared/math/aabb.h"

namespace zoned::physics {

/// A sphere in space.
struct Ball {
    Vec3 centre = Vec3::Zero();
    float radius = 0.0F;

    [[nodiscard]] bool overlaps(const Ball& other) const {
        const float reach = radius + other.radius;
        return (centre - other.centre).squaredNorm() <= reach * reach;
    }
};

/// The axis-aligned box of a shape at a pose: tight, but for surfaces and compounds the box of
/// their turned box. A plane has none: it gets the point at its origin.
Aabb shape_bounds(const Shape& shape, const Vec3& position, const Mat3& rotation);

/// The radius of a ball about the middle of a sphere, capsule, box or hull that lies within it, m;
/// of a compound that of its thinnest part; 0 of others.
float inner_radius(const Shape& shape);

/// The box that holds `box` all along a straight move by `motion`.
inline Aabb swept(const Aabb& box, const Vec3& motion) {
    return {box.lower + motion.cwiseMin(0.0F), box.upper + motion.cwiseMax(0.0F)};
}

inline bool encloses(const Aabb& outer, const Aabb& inner) {
    return (outer.lower.array() <= inner.lower.array()).all() &&
           (inner.upper.array() <= outer.upper.array()).all();
}

}  // namespace zoned::physics
