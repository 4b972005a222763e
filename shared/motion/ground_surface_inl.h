// The template part of Surface; included by ground_surface.h only.
#pragma once

#include <algorithm>

namespace zoned::motion {

template <class Visit>
void Surface::for_each_near(const Aabb& area, Visit&& visit) const {
    if (!box_.overlaps(area)) {
        return;
    }
    const auto bounds_of = [](const FacedTriangle& t) {
        return Aabb{t.corner[0].cwiseMin(t.corner[1]).cwiseMin(t.corner[2]),
                    t.corner[0].cwiseMax(t.corner[1]).cwiseMax(t.corner[2])};
    };
    const CellRange over = cells_over(area);
    for (int z = over.z0; z <= over.z1; ++z) {
        for (int x = over.x0; x <= over.x1; ++x) {
            if (is_grid()) {
                for (int half = 0; half < 2; ++half) {
                    const FacedTriangle t = grid_triangle(x, z, half);
                    if (bounds_of(t).overlaps(area)) {
                        visit(t);
                    }
                }
                continue;
            }
            const auto cell = static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_x_) +
                              static_cast<std::size_t>(x);
            for (std::uint32_t at = cell_start_[cell]; at < cell_start_[cell + 1]; ++at) {
                const FacedTriangle t = mesh_triangle(cell_items_[at]);
                const Aabb bounds = bounds_of(t);
                if (!bounds.overlaps(area)) {
                    continue;
                }
                // Listed in several cells: visited in the first of them that the area has.
                const CellRange own = cells_over(bounds);
                if (x == std::max(own.x0, over.x0) && z == std::max(own.z0, over.z0)) {
                    visit(t);
                }
            }
        }
    }
}

}  // namespace zoned::motion
