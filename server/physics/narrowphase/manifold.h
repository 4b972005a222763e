// Manifold: the contact points of two shapes, and the clipping that finds them for flat faces.
#pragma once

#include "shared/math/types.h"

#include <array>
#include <cstdint>
#include <span>

namespace zoned::physics {

inline constexpr int kMaxManifoldPoints = 4;

/// Without initialisers: lists of candidates live on the stack.
struct ManifoldPoint {
    Vec3 point;             ///< world, halfway between the two surfaces
    float separation;       ///< m along the normal, negative when the surfaces overlap
    std::uint32_t feature;  ///< which features of the shapes meet: the same from step to step
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

/// A corner of a polygon that is being clipped. Without initialisers: polygons live on the stack.
struct Corner {
    Vec3 position;
    std::uint32_t feature;
    std::uint32_t edge;  ///< the edge from this corner to the next
};

/// A convex polygon in space. Each clipping adds one corner at most; corners beyond the capacity,
/// which rounding may add, are dropped.
template <int kCapacity>
struct PolygonOf {
    std::array<Corner, static_cast<std::size_t>(kCapacity)> corners;
    int count = 0;

    void add(const Corner& corner) {
        if (count < kCapacity) {
            corners[static_cast<std::size_t>(count++)] = corner;
        }
    }

    [[nodiscard]] const Corner& operator[](int i) const {
        return corners[static_cast<std::size_t>(i)];
    }
};

/// A quadrilateral clipped by four planes has at most eight corners.
using Polygon = PolygonOf<12>;

/// Keeps the part where normal . x <= offset (Sutherland and Hodgman, "Reentrant polygon clipping",
/// CACM 17, 1974), in `out`. New corners are named by the edge that was cut, shifted by
/// `edge_bits`, and `plane_edge`.
template <int kCapacity>
void clip(const PolygonOf<kCapacity>& polygon,
          const Vec3& normal,
          float offset,
          std::uint32_t plane_edge,
          int edge_bits,
          PolygonOf<kCapacity>& out) {
    out.count = 0;
    for (int i = 0; i < polygon.count; ++i) {
        const Corner& u = polygon[i];
        const Corner& v = polygon[i + 1 < polygon.count ? i + 1 : 0];
        const float du = normal.dot(u.position) - offset;
        const float dv = normal.dot(v.position) - offset;
        if (du <= 0.0F) {
            out.add(u);
        }
        if ((du < 0.0F && dv > 0.0F) || (du > 0.0F && dv < 0.0F)) {
            const Vec3 cut = u.position + (v.position - u.position) * (du / (du - dv));
            const std::uint32_t feature = (((1U << edge_bits) | u.edge) << edge_bits) | plane_edge;
            // Leaving the half-space the outline goes on along the plane, entering it goes on along
            // the edge that was cut.
            out.add({cut, feature, du < 0.0F ? plane_edge : u.edge});
        }
    }
}

/// Adds at most four of the candidates to the manifold: the deepest, and of several that are as
/// deep within 0.2 mm the one farthest from the middle; the one farthest from it; the one that
/// spans the largest triangle with these two; the one that adds the most area on the other side of
/// that triangle. Where shapes are apart by more than that, distances and areas count in inverse
/// proportion to the gap: of the points on a ridge under a box none is left out for a corner in the
/// air. Ties go to the earlier candidate.
void keep_four(std::span<const ManifoldPoint> candidates, Manifold& out);

}  // namespace zoned::physics
