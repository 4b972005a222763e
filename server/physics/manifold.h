// Manifold: where two shapes touch, and the clipping that finds it for flat faces.
#pragma once

#include "shared/math/types.h"

#include <array>
#include <cstdint>

namespace zoned::physics {

inline constexpr int kMaxManifoldPoints = 4;

struct ManifoldPoint {
    Vec3 point = Vec3::Zero();  ///< world, halfway between the two surfaces
    float separation = 0.0F;    ///< m along the normal, negative when the surfaces overlap
    std::uint32_t feature = 0;  ///< which features of the shapes meet: the same from step to step
};

/// Up to four points that share one normal.
struct Manifold {
    Vec3 normal = Vec3::UnitY();  ///< unit, from a to b
    /// Gap along the normal: the shapes cannot overlap before they closed it along this axis. Valid
    /// even when there are no points.
    float separation = 0.0F;
    int count = 0;
    std::array<ManifoldPoint, kMaxManifoldPoints> points;

    void add(const Vec3& point, float gap, std::uint32_t feature) {
        points[static_cast<std::size_t>(count++)] = {point, gap, feature};
    }

    /// The same contact seen from the other body.
    void flip() { normal = -normal; }
};

/// A convex polygon in space; clipping a quadrilateral by four planes leaves at most eight corners.
struct Polygon {
    struct Corner {
        Vec3 position = Vec3::Zero();
        std::uint32_t feature = 0;
        std::uint32_t edge = 0;  // the edge from this corner to the next
    };

    std::array<Corner, 12> corners;
    int count = 0;

    void add(const Corner& corner) { corners[static_cast<std::size_t>(count++)] = corner; }
};

/// Keeps what lies where normal . x <= offset (Sutherland and Hodgman, "Reentrant polygon
/// clipping", CACM 17, 1974). New corners are named by the edge that was cut and `plane_edge`.
void clip(Polygon& polygon, const Vec3& normal, float offset, std::uint32_t plane_edge);

/// Adds at most four of the candidates to the manifold: the deepest; the one farthest from it; the
/// one that spans the largest triangle with these two; the one that adds the most area on the other
/// side of that triangle. Ties go to the earlier candidate.
void keep_four(const std::array<ManifoldPoint, 12>& candidates, int count, Manifold& out);

}  // namespace zoned::physics
