// HullView: the corners, faces and edges of a convex polyhedron as flat arrays, for the pair tests.
#pragma once

#include "server/physics/shapes/shape.h"

#include <array>
#include <cstdint>

namespace zoned::physics {

inline constexpr int kMaxHullVertices = 64;
/// Euler: a convex polyhedron of V corners has at most 2V - 4 faces and 3V - 6 edges.
inline constexpr int kMaxHullFaces = 2 * kMaxHullVertices - 4;
inline constexpr int kMaxHullEdges = 3 * kMaxHullVertices - 6;
/// Corners come in groups of so many, the last one repeated.
inline constexpr int kGroup = 8;

constexpr int padded(int n) {
    return (n + kGroup - 1) / kGroup * kGroup;
}

/// Corners as columns; `count` is a multiple of kGroup, padded with the last corner.
struct PointsView {
    const float* x = nullptr;
    const float* y = nullptr;
    const float* z = nullptr;
    int count = 0;

    [[nodiscard]] Vec3 operator[](int i) const { return {x[i], y[i], z[i]}; }
};

// Both without initialisers, so that tables of them on the stack cost nothing.
struct HullFace {
    Vec3 normal;          ///< unit, outward
    float offset;         ///< every corner has normal . x <= offset, m
    std::uint16_t first;  ///< of its corners in `loops`, counter-clockwise seen from outside
    std::uint16_t corners;
};

/// Runs from corner `from` to `to` with face `left` on its left seen from outside.
struct HullEdge {
    std::uint8_t from, to;
    std::uint8_t left, right;
};

struct HullView {
    PointsView points;
    const HullFace* faces = nullptr;
    const std::uint8_t* loops = nullptr;
    const HullEdge* edges = nullptr;
    int face_count = 0;
    int edge_count = 0;
    /// By edge: the cosine of half the angle between the normals of its faces.
    const float* half_cosines = nullptr;
    Vec3 centre = Vec3::Zero();  ///< of a ball within the hull, which need not be the largest
    float inner = 0.0F;          ///< its radius, m

    [[nodiscard]] Vec3 corner(const HullFace& face, int i) const {
        return points[loops[face.first + i]];
    }
};

/// A box as a polyhedron.
class BoxHull {
  public:
    explicit BoxHull(const Vec3& half_extents);

    [[nodiscard]] HullView view() const;

  private:
    std::array<float, 8> x_, y_, z_;
    std::array<HullFace, 6> faces_;
};

/// The corner that lies farthest along a direction; the first of equals.
int support(const PointsView& points, const Vec3& direction);

/// The smallest normal . x over the corners.
float lowest(const PointsView& points, const Vec3& normal);

}  // namespace zoned::physics
