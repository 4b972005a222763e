#include "server/ai/pathfinding/grid/ground_grid.h"

#include "server/ai/pathfinding/grid/cost.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::pathfinding {

namespace {

/// The number of cells of a side. It is clamped first, because an int cannot hold every float.
int cells_along(float length_m, float cell_m) {
    return static_cast<int>(std::min(length_m / cell_m + 1e-3F, 1e6F));
}

}  // namespace

std::string GroundGrid::defect_of(const GroundRect& area, float cell_m) {
    const float wide = area.max_x - area.min_x;
    const float deep = area.max_z - area.min_z;
    if (!(cell_m > 0.0F) || !std::isfinite(cell_m)) {
        return "cells need a size above 0 m";
    }
    if (!std::isfinite(wide) || !std::isfinite(deep) || !(wide >= cell_m) || !(deep >= cell_m)) {
        return "the ground has no room for a cell of " + std::to_string(cell_m) + " m";
    }
    const int width = cells_along(wide, cell_m);
    const int height = cells_along(deep, cell_m);
    const std::string size = std::to_string(width) + " x " + std::to_string(height) + " cells";
    if (width > GridMap::kMaxSide || height > GridMap::kMaxSide) {
        return size + "; a side has at most " + std::to_string(GridMap::kMaxSide);
    }
    if (static_cast<double>(width) * height > kMostPassable) {
        return size + "; a map has at most " + std::to_string(kMostPassable);
    }
    return {};
}

GroundGrid::GroundGrid(const GroundRect& area, float cell_m)
    : min_x_(area.min_x),
      min_z_(area.min_z),
      cell_m_(cell_m),
      width_(cells_along(area.max_x - area.min_x, cell_m)),
      height_(cells_along(area.max_z - area.min_z, cell_m)) {
    ZONED_ASSERT(defect_of(area, cell_m).empty(), "a grid that can't be laid");
}

bool GroundGrid::contains(Spot s) const {
    const float x = (s.x - min_x_) / cell_m_;
    const float y = (s.z - min_z_) / cell_m_;
    return x >= 0.0F && y >= 0.0F && x < static_cast<float>(width_) &&
           y < static_cast<float>(height_);
}

Cell GroundGrid::cell(Spot s) const {
    // Clamped before the conversion, which is undefined for values that an int cannot hold.
    const auto along = [this](float offset, int cells) {
        const float at = offset / cell_m_;
        return static_cast<std::uint16_t>(at > 0.0F ? std::min(at, static_cast<float>(cells - 1))
                                                    : 0.0F);
    };
    return {along(s.x - min_x_, width_), along(s.z - min_z_, height_)};
}

bool nearest_passable(const GridMap& map, const GroundGrid& grid, Spot s, int reach, Cell& found) {
    const Cell middle = grid.cell(s);
    float least = 0.0F;
    bool any = false;
    const auto consider = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= map.width() || y >= map.height()) {
            return;
        }
        const Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
        if (!map.passable(map.place(c))) {
            return;
        }
        const Spot at = grid.centre(c);
        const float d = (at.x - s.x) * (at.x - s.x) + (at.z - s.z) * (at.z - s.z);
        const bool first = c.y < found.y || (c.y == found.y && c.x < found.x);
        if (!any || d < least || (d == least && first)) {
            any = true;
            least = d;
            found = c;
        }
    };
    for (int r = 0; r <= reach; ++r) {
        // Cells of this ring are at least so far away from any place in the middle cell.
        const float nearest = (static_cast<float>(r) - 0.5F) * grid.cell_m();
        if (any && nearest > 0.0F && nearest * nearest > least) {
            break;
        }
        for (int x = middle.x - r; x <= middle.x + r; ++x) {
            consider(x, middle.y - r);
            consider(x, middle.y + r);
        }
        for (int y = middle.y - r + 1; y < middle.y + r; ++y) {
            consider(middle.x - r, y);
            consider(middle.x + r, y);
        }
    }
    return any;
}

}  // namespace zoned::ai::pathfinding
