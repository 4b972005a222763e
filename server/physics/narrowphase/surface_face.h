// Surface face: a triangle of a surface as one side of the separating axis test.
#pragma once

#include "server/physics/narrowphase/hull_axis.h"
#include "server/physics/shapes/surface.h"

namespace zoned::physics {

/// As a polyhedron of one face.
class SurfaceFace {
  public:
    explicit SurfaceFace(const Triangle& triangle);

    [[nodiscard]] HullView view() const;

    /// As physics::find_axes, with the triangle as a, among those axes that the surface has as
    /// normals: the triangle's, those faces of the hull whose direction the surface bends to, and
    /// the cross products of edges whose arcs meet on the surface's Gauss map.
    [[nodiscard]] HullAxes find_axes(const HullView& hull, float margin, float scale) const;

  private:
    /// `best` holds the triangle's own axis.
    void test_faces(const HullView& hull, float margin, float scale, HullAxis& best) const;
    /// Looks at pairs of edges that may have a gap greater than `least`.
    void test_edges(const HullView& hull, float least, HullAxis& best) const;
    [[nodiscard]] bool may_part(std::size_t i, const Vec3& foot, float least) const;
    [[nodiscard]] bool allows(const Vec3& unit) const;

    const Triangle& triangle_;
    std::array<float, kGroup> x_, y_, z_;
    HullFace face_;
};

}  // namespace zoned::physics
