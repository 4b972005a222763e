// Collide triangle: tests convex shapes against one triangle of a surface.
#pragma once

#include "server/physics/narrowphase/collide.h"
#include "server/physics/narrowphase/hull_axis.h"
#include "server/physics/shapes/surface.h"
#include "shared/math/segment_triangle.h"

#include <optional>

namespace zoned::physics {

/// A convex shape as the triangle tests need it, in the frame of the surface; made once for all
/// triangles of a pair.
class SurfaceVisitor {
  public:
    /// Sphere, box, capsule or hull. `shape` must outlive this.
    explicit SurfaceVisitor(const Placed& shape);

    /// The contact with a triangle, in the frame of the surface, normal from the triangle to the
    /// shape. None when the shape's centre is behind the triangle's plane, and none that the
    /// surface as a whole does not have (see Triangle). `out` is overwritten; `out.separation` is a
    /// lower bound of the gap where there are no points.
    void collide(const Triangle& triangle, float margin, Manifold& out) const;

    /// The shape's centre lies under the surface, where it has no thickness to tell how far: the
    /// contact with the half-space behind the triangle.
    void collide_half_space(const Triangle& triangle, float margin, Manifold& out) const;

    /// Distance to the triangle whatever the side, m; 0 when they overlap. Fills the unit normal
    /// from the triangle to the shape when it is positive.
    [[nodiscard]] float distance(const Triangle& triangle, Vec3& normal) const;

  private:
    void collide_sphere(const Triangle& t, float margin, Manifold& out) const;
    void collide_capsule(const Triangle& t, float margin, Manifold& out) const;
    void collide_hull(const Triangle& t, float margin, Manifold& out) const;

    const Placed& shape_;
    Vec3 half_axis_ = Vec3::Zero();  // capsule
    std::optional<BoxHull> box_;
    std::optional<MovedHull> hull_;
    float scale_ = 1.0F;
};

/// Whether the surface goes on from the feature with this normal (unit, to the front).
bool allows(const Triangle& t, const TrianglePoint& feature, const Vec3& unit);

}  // namespace zoned::physics
