// Near parts: finds the parts of two shapes that may meet: compound children, surface triangles.
#pragma once

#include "server/physics/narrowphase/collide_triangle.h"
#include "server/physics/shapes/compound/bounds.h"
#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/heightfield.h"
#include "server/physics/shapes/mesh.h"

#include <cstdint>

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
