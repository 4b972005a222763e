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

template <class RowAt>
void PointGrid::GridLayer::build(std::span<const Vec3> points,
                                 std::size_t count,
                                 RowAt&& row_at,
                                 float cell_m) {
    ZONED_ASSERT(cell_m > 0.0F, "a cell has a size");
    float max_x = -std::numeric_limits<float>::infinity();
    float max_z = max_x;
    min_x = min_z = std::numeric_limits<float>::infinity();
    std::size_t usable_points = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3& p = points[row_at(i)];
        if (usable(p)) {
            ++usable_points;
            min_x = std::min(min_x, p.x());
            max_x = std::max(max_x, p.x());
            min_z = std::min(min_z, p.z());
            max_z = std::max(max_z, p.z());
        }
    }
    rows.resize(usable_points);
    xs.resize(usable_points);
    zs.resize(usable_points);
    if (usable_points == 0) {
        return;
    }
    double cell_size = cell_m;
    const double width = static_cast<double>(max_x) - min_x;
    const double depth = static_cast<double>(max_z) - min_z;
    while ((std::floor(width / cell_size) + 1.0) * (std::floor(depth / cell_size) + 1.0) >
           kMaxCells) {
        cell_size *= 2.0;
    }
    inverse_cell = static_cast<float>(1.0 / cell_size);
    cells_x = static_cast<int>(width / cell_size) + 1;
    cells_z = static_cast<int>(depth / cell_size) + 1;

    start.assign(static_cast<std::size_t>(cells_x) * static_cast<std::size_t>(cells_z) + 1, 0);
    cell_of.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3& p = points[row_at(i)];
        if (usable(p)) {
            cell_of[i] = static_cast<std::uint32_t>(cell(p.z(), min_z, cells_z) * cells_x +
                                                    cell(p.x(), min_x, cells_x));
            ++start[cell_of[i] + 1];
        }
    }
    for (std::size_t c = 1; c < start.size(); ++c) {
        start[c] += start[c - 1];
    }
    // Filling from the back keeps rows in their order within a cell and leaves starts shifted down
    // to the cell begins.
    for (std::size_t i = count; i-- > 0;) {
        const std::size_t row = row_at(i);
        if (usable(points[row])) {
            const std::uint32_t at = --start[cell_of[i] + 1];
            rows[at] = static_cast<std::uint32_t>(row);
            xs[at] = points[row].x();
            zs[at] = points[row].z();
        }
    }
    // Now start[c + 1] is the begin of cell c: shift back.
    for (std::size_t c = 0; c + 1 < start.size(); ++c) {
        start[c] = start[c + 1];
    }
    start.back() = static_cast<std::uint32_t>(usable_points);
}

void PointGrid::build(std::span<const Vec3> points, float cell_m) {
    kept_.rows.clear();
    kept_at_.clear();
    kept_points_ = 0;
    loose_.build(points, points.size(), [](std::size_t i) { return i; }, cell_m);
}

void PointGrid::keep(std::span<const Vec3> points,
                     std::span<const std::uint32_t> rows,
                     float cell_m) {
    loose_.rows.clear();
    kept_.build(points, rows.size(), [rows](std::size_t i) { return rows[i]; }, cell_m);
    kept_at_.assign(points.size(), kNone);
    for (std::size_t i = 0; i < kept_.rows.size(); ++i) {
        kept_at_[kept_.rows[i]] = static_cast<std::uint32_t>(i);
    }
    kept_points_ = kept_.rows.size();
}

void PointGrid::follow(std::span<const Vec3> points,
                       std::span<const std::uint32_t> loose,
                       float cell_m) {
    for (std::size_t row = points.size(); row < kept_at_.size(); ++row) {
        forget(static_cast<std::uint32_t>(row));
    }
    kept_at_.resize(points.size(), kNone);
    for (const std::uint32_t row : loose) {
        forget(row);
    }
    loose_.build(points, loose.size(), [loose](std::size_t i) { return loose[i]; }, cell_m);
}

void PointGrid::forget(std::uint32_t row) {
    if (kept_at_[row] != kNone) {
        kept_.xs[kept_at_[row]] = std::numeric_limits<float>::quiet_NaN();
        kept_at_[row] = kNone;
        --kept_points_;
    }
}

}  // namespace zoned::spatial
