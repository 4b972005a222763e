#include "server/physics/shapes/convex/hull_view.h"

#include "server/physics/simd/lanes.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// Corner i of a box has the sign of bit k of i along axis k. Face 2 k + s looks along axis k,
/// negative for s = 0.
constexpr std::array<std::uint8_t, 24> kBoxLoops = {0, 4, 6, 2, 1, 3, 7, 5,   // -x, +x
                                                    0, 1, 5, 4, 2, 6, 7, 3,   // -y, +y
                                                    0, 2, 3, 1, 4, 5, 7, 6};  // -z, +z

constexpr std::array<HullEdge, 12> kBoxEdges = {{{0, 1, 2, 4},
                                                 {2, 3, 4, 3},
                                                 {4, 5, 5, 2},
                                                 {6, 7, 3, 5},
                                                 {0, 2, 4, 0},
                                                 {1, 3, 1, 4},
                                                 {4, 6, 0, 5},
                                                 {5, 7, 5, 1},
                                                 {0, 4, 0, 2},
                                                 {1, 5, 2, 1},
                                                 {2, 6, 3, 0},
                                                 {3, 7, 1, 3}}};

/// Of 45 degrees.
constexpr float kHalfRight = 0.70710678F;
constexpr std::array<float, 12> kBoxHalfCosines = {kHalfRight,
                                                   kHalfRight,
                                                   kHalfRight,
                                                   kHalfRight,
                                                   kHalfRight,
                                                   kHalfRight,
                                                   kHalfRight,
                                                   kHalfRight,
                                                   kHalfRight,
                                                   kHalfRight,
                                                   kHalfRight,
                                                   kHalfRight};

}  // namespace

BoxHull::BoxHull(const Vec3& half_extents) {
    for (std::size_t i = 0; i < 8; ++i) {
        x_[i] = (i & 1) != 0 ? half_extents.x() : -half_extents.x();
        y_[i] = (i & 2) != 0 ? half_extents.y() : -half_extents.y();
        z_[i] = (i & 4) != 0 ? half_extents.z() : -half_extents.z();
    }
    for (int f = 0; f < 6; ++f) {
        const Vec3 normal = Vec3::Unit(f / 2) * ((f & 1) != 0 ? 1.0F : -1.0F);
        faces_[static_cast<std::size_t>(f)] = {
            normal, half_extents[f / 2], static_cast<std::uint16_t>(4 * f), 4};
    }
}

HullView BoxHull::view() const {
    return {{x_.data(), y_.data(), z_.data(), 8},
            faces_.data(),
            kBoxLoops.data(),
            kBoxEdges.data(),
            6,
            12,
            kBoxHalfCosines.data(),
            Vec3::Zero(),
            std::min({faces_[0].offset, faces_[2].offset, faces_[4].offset})};
}

int support(const PointsView& points, const Vec3& direction) {
    const Lanes dx = lanes(direction.x());
    const Lanes dy = lanes(direction.y());
    const Lanes dz = lanes(direction.z());
    Lanes best = lanes(-INFINITY);
    Lanes where = lanes(0.0F);
    for (int i = 0; i < points.count; i += kGroup) {
        const Lanes along =
            load(points.x + i) * dx + load(points.y + i) * dy + load(points.z + i) * dz;
        where = along > best ? lanes(static_cast<float>(i)) : where;
        best = max(along, best);
    }
    std::size_t lane = 0;
    int index = static_cast<int>(where[0]);
    for (std::size_t k = 1; k < kLanes; ++k) {
        const int i = static_cast<int>(where[k]) + static_cast<int>(k);
        if (best[k] > best[lane] || (best[k] == best[lane] && i < index)) {
            lane = k;
            index = i;
        }
    }
    return index;
}

float lowest(const PointsView& points, const Vec3& normal) {
    const Lanes nx = lanes(normal.x());
    const Lanes ny = lanes(normal.y());
    const Lanes nz = lanes(normal.z());
    Lanes least = lanes(INFINITY);
    for (int i = 0; i < points.count; i += kGroup) {
        const Lanes along =
            load(points.x + i) * nx + load(points.y + i) * ny + load(points.z + i) * nz;
        least = min(along, least);
    }
    return lowest_of(least);
}

}  // namespace zoned::physics
