// Aabb: an axis-aligned bounding box.
#pragma once

#include "shared/math/types.h"

namespace zoned {

/// Closed box [lower, upper], metres. The default box is a point at the origin.
struct Aabb {
    Vec3 lower = Vec3::Zero();
    Vec3 upper = Vec3::Zero();

    [[nodiscard]] bool overlaps(const Aabb& other) const {
        return (lower.array() <= other.upper.array()).all() &&
               (other.lower.array() <= upper.array()).all();
    }

    [[nodiscard]] bool contains(const Vec3& point) const {
        return (lower.array() <= point.array()).all() && (point.array() <= upper.array()).all();
    }

    /// The box grown by `margin` metres on every side.
    [[nodiscard]] Aabb grown(float margin) const {
        return {lower - Vec3::Constant(margin), upper + Vec3::Constant(margin)};
    }
};

}  // namespace zoned
