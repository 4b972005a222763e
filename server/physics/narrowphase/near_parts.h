// Near parts: finds the parts of two shapes that may meet: compound children, surface triangles.
#pragma once

#include "server/physics/narrowphase/collide_triangle.h"
#include "server/physics/shapes/compound/bounds.h"
#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/heightfield.h"
#include "server/physics/shapes/mesh.h"
#include "server/physics/simd/lanes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace zoned::physics {

/// A convex shape or a surface, alone or as part of a compound.
struct PartPlaced {
    Placed placed;
    const Compound::CompoundChild* part = nullptr;  ///< null: the body's own shape
    std::uint32_t index = 0;
};

/// Calls visit(PartPlaced) for the parts of `shape` whose boxes overlap that of `other`, swept
/// along `travel` (relative to the shape, world axes) and grown by `margin`.
template <class Visit>
void for_parts_near(const Placed& shape,
                    const Placed& other,
                    const Vec3& travel,
                    float margin,
                    Visit&& visit) {
    if (shape.shape.kind != ShapeKind::kCompound) {
        visit(PartPlaced{shape, nullptr, 0});
        return;
    }
    const Compound& compound = compound_of(shape.shape);
    const auto at = [&](std::uint32_t i) {
        const Compound::CompoundChild& part = compound.parts()[i];
        const Mat3 rotation = shape.rotation * part.rotation;
        const Placed placed{part.part.shape, shape.to_world(part.part.frame.position), rotation};
        visit(PartPlaced{placed, &part, i});
    };
    if (other.shape.kind == ShapeKind::kPlane) {
        for (std::uint32_t i = 0; i < compound.parts().size(); ++i) {
            at(i);
        }
        return;
    }
    const Mat3 turn = shape.rotation.transpose() * other.rotation;
    const Aabb box = shape_bounds(other.shape, shape.to_local(other.position), turn);
    compound.tree().query(swept(box.grown(margin), shape.rotation.transpose() * travel), at);
}

inline Aabb box_of(const Triangle& t) {
    return {t.corner[0].cwiseMin(t.corner[1]).cwiseMin(t.corner[2]),
            t.corner[0].cwiseMax(t.corner[1]).cwiseMax(t.corner[2])};
}

/// The triangles of a mesh near all of a compound, so that its parts need not look for their own.
class NearTriangles {
  public:
    static constexpr std::size_t kMost = 256;

    NearTriangles() { triangles_.reserve(kMost); }

    void clear() { triangles_.clear(); }

    /// False where there is no room.
    bool add(const Triangle& triangle) {
        const std::size_t i = triangles_.size();
        if (i == kMost) {
            return false;
        }
        if (i % kLanes == 0) {
            // No box overlaps those of lanes that stay empty.
            std::fill_n(bounds_[0].begin() + static_cast<std::ptrdiff_t>(i), kLanes, INFINITY);
        }
        const Aabb box = box_of(triangle);
        for (int axis = 0; axis < 3; ++axis) {
            bounds_[static_cast<std::size_t>(axis)][i] = box.lower[axis];
            bounds_[static_cast<std::size_t>(axis + 3)][i] = box.upper[axis];
        }
        triangles_.push_back(triangle);
        return true;
    }

    /// Calls visit(triangle) for those whose boxes overlap an area, in the order of `add`.
    template <class Visit>
    void query(const Aabb& area, Visit&& visit) const {
        for (std::size_t i = 0; i < triangles_.size(); i += kLanes) {
            auto meets = lanes(area.upper.x()) >= load(&bounds_[0][i]);
            meets &= lanes(area.upper.y()) >= load(&bounds_[1][i]);
            meets &= lanes(area.upper.z()) >= load(&bounds_[2][i]);
            meets &= lanes(area.lower.x()) <= load(&bounds_[3][i]);
            meets &= lanes(area.lower.y()) <= load(&bounds_[4][i]);
            meets &= lanes(area.lower.z()) <= load(&bounds_[5][i]);
            if (!any(meets)) {
                continue;
            }
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                if (meets[lane] != 0) {
                    visit(triangles_[i + lane]);
                }
            }
        }
    }

  private:
    std::vector<Triangle> triangles_;
    std::array<std::array<float, kMost>, 6> bounds_;  // lower x, y, z, upper x, y, z
};

/// Calls visit(triangle) for the triangles of a mesh whose boxes overlap an area, in its own frame.
template <class Visit>
void for_triangles(const TriangleMesh& mesh, const Aabb& area, Visit&& visit) {
    mesh.tree().query(area, [&](std::uint32_t i) {
        const Triangle t = mesh.triangle(i);
        if (box_of(t).overlaps(area)) {
            visit(t);
        }
    });
}

template <class Visit>
void for_triangles(const Heightfield& field, const Aabb& area, Visit&& visit) {
    const Heightfield::HeightfieldCells cells = field.cells_over(area);
    for (std::uint32_t k = cells.first_k; k < cells.last_k; ++k) {
        for (std::uint32_t i = cells.first_i; i < cells.last_i; ++i) {
            const std::array<float, 4> y{field.height(i, k),
                                         field.height(i + 1, k),
                                         field.height(i, k + 1),
                                         field.height(i + 1, k + 1)};
            // The ground has no underside: a part above a cell's highest point is clear of it.
            if (*std::max_element(y.begin(), y.end()) >= area.lower.y()) {
                visit(field.triangle(i, k, 0));
                visit(field.triangle(i, k, 1));
            }
        }
    }
}

}  // namespace zoned::physics
