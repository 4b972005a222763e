// ConvexHull: a convex polyhedron built from points, with its mass properties.
#pragma once

#include "server/physics/shapes/convex/hull_view.h"
#include "shared/core/result.h"
#include "shared/math/aabb.h"

#include <memory>
#include <span>
#include <vector>

namespace zoned::physics {

inline constexpr std::size_t kMaxHullPoints = 1U << 16;

/// Immutable. Its corners are given about its centre of mass and along its principal axes.
class ConvexHull final : public Geometry {
  public:
    /// Filled in by build_hull.
    struct HullTables {
        std::vector<float> x, y, z;  ///< padded
        std::vector<HullFace> faces;
        std::vector<std::uint8_t> loops;
        std::vector<HullEdge> edges;
        std::vector<float> half_cosines;  ///< see HullView
        int vertices = 0;
        float volume = 0.0F;
        float radius = 0.0F;
        float inner = 0.0F;  ///< of a ball about the centre of mass within the hull, m
        Vec3 moments_per_kg = Vec3::Zero();
        Aabb box;
    };

    explicit ConvexHull(HullTables tables);

    [[nodiscard]] const HullView& view() const { return view_; }

    [[nodiscard]] int vertex_count() const { return t_.vertices; }

    [[nodiscard]] float volume() const { return t_.volume; }  ///< m3

    /// Of the smallest sphere about the centre of mass that holds it, m.
    [[nodiscard]] float radius() const { return t_.radius; }

    /// Principal moments of inertia of a solid of 1 kg and uniform density, m2.
    [[nodiscard]] const Vec3& moments_per_kg() const { return t_.moments_per_kg; }

    /// Tight, in its own axes.
    [[nodiscard]] const Aabb& box() const { return t_.box; }

    /// All there is, for another hull like it.
    [[nodiscard]] const HullTables& tables() const { return t_; }

  private:
    HullTables t_;
    HullView view_;  // of t_
};

/// The hull of a shape of kind kHull.
inline const ConvexHull& hull_of(const Shape& shape) {
    return static_cast<const ConvexHull&>(*shape.geometry);
}

struct HullOptions {
    int max_vertices = kMaxHullVertices;  ///< 4..kMaxHullVertices
    /// Points that stand out by less are left out, and faces whose corners lie in a plane up to so
    /// much are one face, m. 0: 1e-5 of the extent, at most 0.1 mm or the rounding of floats.
    float tolerance = 0.0F;
};

struct BuiltHull {
    std::shared_ptr<const ConvexHull> hull;
    /// Where the hull's own frame (centre of mass, principal axes) lies in the coordinates of the
    /// points. To stand where the points are, a body takes this pose.
    Frame frame;
    /// How far the points that were left out stand out of the faces, m.
    float cut_off = 0.0F;
};

/// The convex hull of 4 to kMaxHullPoints points in any order, within kMaxCoordinate. Of a hull
/// with more corners than `max_vertices` the farthest ones are kept, and `cut_off` gives the loss.
/// Fails with the reason when a point is not finite or out of range, or when the hull is thinner
/// than kMinSize (a plane, a line, a point) or larger than kMaxSize.
core::Result<BuiltHull> build_hull(std::span<const Vec3> points, const HullOptions& options = {});

}  // namespace zoned::physics
