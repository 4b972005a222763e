#include "server/spatial/point_grid.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::spatial {

namespace {

constexpr double kMaxCells = 4194304.0;

bool usable(const Vec3& p) {
    return std::isfinite(p.x()) && std::isfinite(p.z());
}

}  // namespace

void PointGrid::build(std::span<const Vec3> points, float cell_m) {
    ZONED_ASSERT(cell_m > 0.0F, "a cell has a size");
    float max_x = -std::numeric_limits<float>::infinity();
    float max_z = max_x;
    min_x_ = min_z_ = std::numeric_limits<float>::infinity();
    std::size_t usable_points = 0;
    for (const Vec3& p : points) {
        if (usable(p)) {
            ++usable_points;
            min_x_ = std::min(min_x_, p.x());
            max_x = std::max(max_x, p.x());
            min_z_ = std::min(min_z_, p.z());
            max_z = std::max(max_z, p.z());
        }
    }
    rows_.resize(usable_points);
    xs_.resize(usable_points);
    zs_.resize(usable_points);
    if (usable_points == 0) {
        return;
    }
    double cell = cell_m;
    const double width = static_cast<double>(max_x) - min_x_;
    const double depth = static_cast<double>(max_z) - min_z_;
    while ((std::floor(width / cell) + 1.0) * (std::floor(depth / cell) + 1.0) > kMaxCells) {
        cell *= 2.0;
    }
    inverse_cell_ = static_cast<float>(1.0 / cell);
    cells_x_ = static_cast<int>(width / cell) + 1;
    cells_z_ = static_cast<int>(depth / cell) + 1;

    start_.assign(static_cast<std::size_t>(cells_x_) * static_cast<std::size_t>(cells_z_) + 1, 0);
    cell_of_.resize(points.size());
    for (std::size_t row = 0; row < points.size(); ++row) {
        if (usable(points[row])) {
            const int cx = this->cell(points[row].x(), min_x_, cells_x_);
            const int cz = this->cell(points[row].z(), min_z_, cells_z_);
            cell_of_[row] = static_cast<std::uint32_t>(cz * cells_x_ + cx);
            ++start_[cell_of_[row] + 1];
        }
    }
    for (std::size_t c = 1; c < start_.size(); ++c) {
        start_[c] += start_[c - 1];
    }
    // Filling from the back keeps rows ascending within a cell and leaves start_ shifted down to
    // the cell begins.
    for (std::size_t row = points.size(); row-- > 0;) {
        if (usable(points[row])) {
            const std::uint32_t at = --start_[cell_of_[row] + 1];
            rows_[at] = static_cast<std::uint32_t>(row);
            xs_[at] = points[row].x();
            zs_[at] = points[row].z();
        }
    }
    // Now start_[c + 1] is the begin of cell c: shift back.
    for (std::size_t c = 0; c + 1 < start_.size(); ++c) {
        start_[c] = start_[c + 1];
    }
    start_.back() = static_cast<std::uint32_t>(usable_points);
}

}  // namespace zoned::spatial
