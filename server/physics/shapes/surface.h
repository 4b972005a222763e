// Surface: the triangles of static surfaces (meshes, heightfields), and the surface beyond their
// edges.
#pragma once

#include "shared/math/types.h"

#include <array>
#include <cstdint>

namespace zoned::physics {

/// How the surface bends back at an edge, as an angle 0..180 degrees: where it is flat or bends
/// towards the front the angle is zero. An edge with nothing beyond it is open to 90 degrees.
struct EdgeBend {
    float cosine = 1.0F;
    float sine = 0.0F;

    static constexpr EdgeBend flat() { return {1.0F, 0.0F}; }

    static constexpr EdgeBend open() { return {0.0F, 1.0F}; }
};

/// A triangle, solid behind, counter-clockwise seen from the front. Edge i runs from corner i to
/// corner i + 1.
///
/// Contacts keep to the surface as a whole. Within the triangle their normal is its normal; at an
/// edge it lies between the normals on both sides. So an edge that is flat or bends to the front
/// has no contacts of its own, and a body that slides over a floor of many triangles never notices
/// them.
struct Triangle {
    std::array<Vec3, 3> corner;
    Vec3 normal;  ///< unit
    std::array<EdgeBend, 3> bend;
    std::uint32_t id = 0;

    [[nodiscard]] Vec3 edge(std::size_t i) const { return corner[(i + 1) % 3] - corner[i]; }

    /// Unit, in the plane of the triangle, out of it across edge i.
    [[nodiscard]] Vec3 outward(std::size_t i) const { return edge(i).cross(normal).normalized(); }

    [[nodiscard]] float height(const Vec3& p) const { return normal.dot(p - corner[0]); }

    /// Whether the surface has this normal somewhere along edge i, or would have it farther in: a
    /// normal beyond the bend belongs to the surface beyond the edge.
    [[nodiscard]] bool allows(std::size_t i, const Vec3& unit) const;
};

/// Unit normal of the triangle, and twice its area; zero vector when it has no area.
Vec3 triangle_normal(const Vec3& a, const Vec3& b, const Vec3& c, float& twice_area);

/// The bend at edge i of a triangle towards the neighbour with that normal whose third corner is
/// `apex`.
EdgeBend bend_towards(const Triangle& t, std::size_t i, const Vec3& normal, const Vec3& apex);

}  // namespace zoned::physics
