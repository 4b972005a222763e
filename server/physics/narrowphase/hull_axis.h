// Hull axis: the separating axis test of two convex polyhedra.
#pragma once

#include "server/physics/narrowphase/axis_choice.h"
#include "server/physics/shapes/convex/hull_view.h"

namespace zoned::physics {

enum class AxisKind {
    kFaceA,
    kFaceB,
    kEdges
};

struct HullAxis {
    float separation = -INFINITY;  ///< gap along the normal, m
    AxisKind kind = AxisKind::kFaceA;
    int i = 0;                    ///< face or edge of a
    int j = 0;                    ///< face or edge of b
    Vec3 normal = Vec3::UnitY();  ///< unit, from a to b
};

/// A polyhedron moved into another frame; it shares its tables with the one that it comes from.
class MovedHull {
  public:
    MovedHull(const HullView& hull, const Mat3& rotation, const Vec3& position);

    [[nodiscard]] HullView view() const;

  private:
    HullView from_;
    alignas(32) std::array<float, kMaxHullVertices> x_, y_, z_;
    std::array<HullFace, kMaxHullFaces> faces_;
};

/// The best axis of each sort.
struct HullAxes {
    HullAxis face;
    /// Of the pairs that could win; separation -infinity: there are none.
    HullAxis edges;

    /// The axis that decides the kind of contact.
    [[nodiscard]] const HullAxis& best(float scale) const {
        return edges.separation > face.separation + kEdgeBias * scale ? edges : face;
    }
};

/// The axes of largest separation (of least overlap when it is negative), from two sources. One is
/// the normals of all faces. The other is the cross products of pairs of edges that are edges of
/// the Minkowski difference: their arcs on the Gauss map cross (Gregorius, "The separating axis
/// test between convex polyhedra", GDC 2013). Axes that cannot win are left out, see AxisBound.
/// Both hulls are given in one frame. Stops after the faces of a, or of b, when these part the
/// hulls by more than `margin`. `scale` shrinks the biases for small bodies.
HullAxes find_axes(const HullView& a, const HullView& b, float margin, float scale);

}  // namespace zoned::physics
