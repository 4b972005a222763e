// The template part of StaticGeometry; included by static_geometry.h only.
#pragma once

#include <algorithm>

namespace zoned::motion {

template <class Visit>
void StaticGeometry::for_each_near(const Aabb& area, Visit&& visit) const {
    visit_near(area, 0, static_cast<std::uint32_t>(fixed_), visit);
}

template <class Visit>
void StaticGeometry::for_each_near(const Aabb& area, Tick tick, Visit&& visit) const {
    if (doors_.empty() || tick == kAllDoorsOpen) {
        for_each_near(area, visit);
        return;
    }
    visit_near(area, 0, first_platform(), [&](std::uint32_t index) {
        if (index < fixed_ || shut_at(index - static_cast<std::uint32_t>(fixed_), tick)) {
            visit(index);
        }
    });
}

template <class Visit>
void StaticGeometry::for_each_door_near(const Aabb& area, Visit&& visit) const {
    const auto first = static_cast<std::uint32_t>(fixed_);
    visit_near(area, first, first_platform(), [&](std::uint32_t index) { visit(index - first); });
}

template <class Visit>
void StaticGeometry::for_each_platform_near(const Aabb& area, Visit&& visit) const {
    const std::uint32_t first = first_platform();
    const auto end = first + static_cast<std::uint32_t>(platforms_.size());
    visit_near(area, first, end, [&](std::uint32_t index) { visit(index - first); });
}

template <class Visit>
void StaticGeometry::visit_near(const Aabb& area,
                                std::uint32_t first,
                                std::uint32_t end,
                                Visit&& visit) const {
    if (first == end) {
        return;
    }
    const int x0 = cell_of(area.lower.x(), origin_x_, cells_x_);
    const int x1 = cell_of(area.upper.x(), origin_x_, cells_x_);
    const int z0 = cell_of(area.lower.z(), origin_z_, cells_z_);
    const int z1 = cell_of(area.upper.z(), origin_z_, cells_z_);
    // Merge the few sorted cell lists by repeatedly taking the smallest index: no memory,
    // ascending, no doubles.
    std::uint32_t next = first;
    for (;;) {
        std::uint32_t best = end;
        for (int z = z0; z <= z1; ++z) {
            for (int x = x0; x <= x1; ++x) {
                const std::size_t cell = static_cast<std::size_t>(z * cells_x_ + x);
                const auto begin = cell_items_.begin() + cell_start_[cell];
                const auto stop = cell_items_.begin() + cell_start_[cell + 1];
                const auto it = std::lower_bound(begin, stop, next);
                if (it != stop && *it < best) {
                    best = *it;
                }
            }
        }
        if (best == end) {
            return;
        }
        if (bounds_[best].overlaps(area)) {
            visit(best);
        }
        next = best + 1;
    }
}

}  // namespace zoned::motion
