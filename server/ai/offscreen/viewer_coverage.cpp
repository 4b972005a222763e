#include "server/ai/offscreen/viewer_coverage.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

/// The number of cells per radius. Cells are wider where the area is large.
constexpr float kCellsPerRadius = 8.0F;
constexpr float kMostCells = 1024.0F;  ///< per side

}  // namespace

void ViewerCoverage::build(std::span<const Vec2> viewers, float radius_m) {
    columns_ = rows_ = 0;
    if (viewers.empty()) {
        return;
    }
    Vec2 low = viewers.front();
    Vec2 high = low;
    for (const Vec2& viewer : viewers) {
        low = low.cwiseMin(viewer);
        high = high.cwiseMax(viewer);
    }
    const Vec2 size = (high - low).array() + 2.0F * radius_m;
    cell_m_ = std::max(radius_m / kCellsPerRadius, size.maxCoeff() / kMostCells);
    per_m_ = 1.0F / cell_m_;
    origin_ = low.array() - radius_m;
    columns_ = static_cast<std::size_t>(size.x() * per_m_) + 2;
    rows_ = static_cast<std::size_t>(size.y() * per_m_) + 2;
    cells_.assign(columns_ * rows_, 0);
    for (const Vec2& viewer : viewers) {
        mark(viewer, radius_m);
    }
}

/// Marks row by row the cells that the circle touches.
void ViewerCoverage::mark(const Vec2& viewer, float radius_m) {
    const Vec2 centre = (viewer - origin_) * per_m_;
    const float radius = radius_m * per_m_;
    const auto first = static_cast<std::size_t>(std::max(0.0F, centre.y() - radius));
    const std::size_t last =
        std::min(rows_ - 1, static_cast<std::size_t>(std::max(0.0F, centre.y() + radius)));
    for (std::size_t row = first; row <= last; ++row) {
        // The least distance of the row of cells to the viewer's z.
        const auto top = static_cast<float>(row);
        const float dz = std::max({0.0F, top - centre.y(), centre.y() - (top + 1.0F)});
        const float half = std::sqrt(std::max(0.0F, radius * radius - dz * dz)) + 0.01F;
        const auto begin = static_cast<std::size_t>(std::max(0.0F, centre.x() - half));
        const std::size_t end =
            std::min(columns_ - 1, static_cast<std::size_t>(std::max(0.0F, centre.x() + half)));
        std::uint8_t* const cells = &cells_[row * columns_];
        std::fill(cells + begin, cells + end + 1, std::uint8_t{1});
    }
}

}  // namespace zoned::ai
