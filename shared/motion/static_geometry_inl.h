// The template part of StaticGeometry; included by static_geometry.h only.
#pragma once

#include <algorithm>

namespace zoned::motion {

template <class Visit>
void StaticGeometry::for_each_near(const Aabb& area, Visit&& visit) const {
    if (boxes_.empty()) {
        return;
    }
    const int x0 = cell_of(area.lower.x(), origin_x_, cells_x_);
    const int x1 = cell_of(area.upper.x(), origin_x_, cells_x_);
    const int z0 = cell_of(area.lower.z(), origin_z_, cells_z_);
    const int z1 = cell_of(area.upper.z(), origin_z_, cells_z_);
    // Merge the few sorted cell lists by repeatedly taking the smallest index: no memory,
    // ascending, no doubles.
    std::uint32_t next = 0;
    for (;;) {
        std::uint32_t best = static_cast<std::uint32_t>(boxes_.size());
        for (int z = z0; z <= z1; ++z) {
            for (int x = x0; x <= x1; ++x) {
                const std::size_t cell = static_cast<std::size_t>(z * cells_x_ + x);
                const auto begin = cell_items_.begin() + cell_start_[cell];
                const auto end = cell_items_.begin() + cell_start_[cell + 1];
                const auto it = std::lower_bound(begin, end, next);
                if (it != end && *it < best) {
                    best = *it;
                }
            }
        }
        if (best == boxes_.size()) {
            return;
        }
        if (bounds_[best].overlaps(area)) {
            visit(best);
        }
        next = best + 1;
    }
}

}  // namespace zoned::motion
