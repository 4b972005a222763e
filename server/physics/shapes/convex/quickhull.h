// Quickhull: the triangles of the convex hull of points, with exact decisions.
#pragma once

#include "shared/core/result.h"
#include "shared/math/types.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::physics {

/// One triangle of a closed surface, counter-clockwise seen from outside.
struct SurfaceTriangle {
    std::array<int, 3> corner{};     ///< indices of points
    std::array<int, 3> neighbour{};  ///< the triangle across the edge from corner i to corner i + 1
};

struct TriangleHull {
    std::vector<SurfaceTriangle> triangles;
    int vertices = 0;      ///< points that are corners of triangles
    double cut_off = 0.0;  ///< how far a point that was left out may lie outside, m
};

/// The hull of `points` (Barber, Dobkin, Huhdanpaa, "The Quickhull algorithm for convex hulls", ACM
/// TOMS 22(4), 1996). The farthest point of all comes first, so that a hull that stops at
/// `max_vertices` is a good one. Points that stand out by `tolerance` metres or less are left out.
///
/// Sides of planes are decided without rounding. The points are snapped to a grid of 2^-30 of their
/// extent, finer than the rounding of the input floats. There the sign of a determinant is exact in
/// 128 bits. So the surface is closed and convex on the grid for any input: doubled, collinear and
/// coplanar points are no special cases.
///
/// Points must be finite. Fails with the reason when they lie in a plane within `tolerance`.
core::Result<TriangleHull> quickhull(std::span<const Vec3d> points,
                                     int max_vertices,
                                     double tolerance);

}  // namespace zoned::physics
