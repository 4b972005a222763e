// Hulls: hulls and point clouds for the tests of the physics.
#pragma once

#include "server/physics/shapes/convex/hull.h"
#include "shared/core/rng.h"

#include <vector>

namespace zoned::physics {

inline std::vector<Vec3> box_corners(const Vec3& half) {
    std::vector<Vec3> points;
    for (int i = 0; i < 8; ++i) {
        points.emplace_back((i & 1) != 0 ? half.x() : -half.x(),
                            (i & 2) != 0 ? half.y() : -half.y(),
                            (i & 4) != 0 ? half.z() : -half.z());
    }
    return points;
}

inline std::vector<Vec3> random_points(core::Rng& rng, int count, float size) {
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
        const float x = rng.range(-size, size);
        const float y = rng.range(-size, size);
        points.emplace_back(x, y, rng.range(-size, size));
    }
    return points;
}

inline Quat random_rotation(core::Rng& rng) {
    const float w = rng.range(-1, 1);
    const float x = rng.range(-1, 1);
    const float y = rng.range(-1, 1);
    return Quat(w, x, y, rng.range(-1, 1)).normalized();
}

inline Shape hull_shape(const std::vector<Vec3>& points) {
    return Shape::hull(build_hull(points)->hull);
}

}  // namespace zoned::physics
