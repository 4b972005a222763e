// Hull clip: the contact points of two convex polyhedra along an axis.
#pragma once

#include "server/physics/narrowphase/hull_axis.h"
#include "server/physics/narrowphase/manifold.h"

#include <algorithm>

namespace zoned::physics {

/// A face with the most corners clipped by one with the most sides, and some room for rounding.
using FacePolygon = PolygonOf<2 * kMaxHullVertices + 16>;

/// Adds the points of contact along the axis that are at most `margin` metres apart: the face of
/// the one hull that faces the reference face most, clipped by that face's sides, or the nearest
/// points of two edges. All in the hulls' common frame; `out.normal` is set already.
void add_points(const HullView& a,
                const HullView& b,
                const HullAxis& axis,
                float margin,
                Manifold& out);

/// Of the faces around the corner that lies farthest along a direction, the one that looks most
/// along it. (Another face may look along it more and yet be far from the contact.)
int facing(const HullView& hull, const Vec3& direction);

/// Nearest points of two segments that are not parallel, each with one end and the vector to the
/// other (Ericson, Real-Time Collision Detection, section 5.1.9).
struct SegmentPoints {
    Vec3 on_a, on_b;
};

SegmentPoints nearest_on_edges(const Vec3& pa, const Vec3& da, const Vec3& pb, const Vec3& db);

/// Biases that are right for a body of half a metre, for one of radius r.
inline float bias_scale(float radius) {
    return std::min(1.0F, 2.0F * radius);
}

}  // namespace zoned::physics
