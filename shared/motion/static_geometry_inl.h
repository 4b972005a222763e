// The template part of StaticGeometry; included by static_geometry.h only.
#pragma once

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
    const CellRange over = cells_over(area);
    for (std::uint32_t index = next_in(over, first, end); index != end;
         index = next_in(over, index + 1, end)) {
        if (bounds_[index].overlaps(area)) {
            visit(index);
        }
    }
}

}  // namespace zoned::motion
