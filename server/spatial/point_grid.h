// PointGrid: a uniform grid over points in the x-z plane, rebuilt by counting sort whenever it is
// needed.
#pragma once

#include "shared/math/types.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::spatial {

/// Answers "which points lie near here". Built once per tick for perception and interest. No
/// allocation after warm-up.
class PointGrid {
  public:
    /// Indexes `points` (rows are their positions in the span). `cell_m` > 0; cells grow where the
    /// extent would need more than 4,194,304 of them. Points that are not finite are left out.
    void build(std::span<const Vec3> points, float cell_m);

    /// Calls `visit(row, distance_squared)` for each point within `radius` (m, closed) of (x, z),
    /// horizontally; order is by cell, then by row: the same for the same build.
    template <class Visit>
    void for_each_within(float x, float z, float radius, Visit&& visit) const {
        if (rows_.empty()) {
            return;
        }
        const float r2 = radius * radius;
        // A little wider than the radius: the differences below are rounded, so that a point may
        // count as within the radius that lies a rounding outside it, in the next cell.
        const float reach_x = radius + 1e-6F * (radius + std::abs(x));
        const float reach_z = radius + 1e-6F * (radius + std::abs(z));
        const int x0 = cell(x - reach_x, min_x_, cells_x_);
        const int x1 = cell(x + reach_x, min_x_, cells_x_);
        const int z0 = cell(z - reach_z, min_z_, cells_z_);
        const int z1 = cell(z + reach_z, min_z_, cells_z_);
        for (int cz = z0; cz <= z1; ++cz) {
            const std::size_t line =
                static_cast<std::size_t>(cz) * static_cast<std::size_t>(cells_x_);
            const std::uint32_t end = start_[line + static_cast<std::size_t>(x1) + 1];
            for (std::uint32_t i = start_[line + static_cast<std::size_t>(x0)]; i < end; ++i) {
                const float dx = xs_[i] - x;
                const float dz = zs_[i] - z;
                const float d2 = dx * dx + dz * dz;
                if (d2 <= r2) {
                    visit(rows_[i], d2);
                }
            }
        }
    }

    [[nodiscard]] std::size_t size() const { return rows_.size(); }

  private:
    [[nodiscard]] int cell(float coordinate, float origin, int cells) const {
        const float c = (coordinate - origin) * inverse_cell_;
        // Also zero for what is not a number: a query there finds nothing.
        return !(c > 0.0F) ? 0 : (c >= static_cast<float>(cells) ? cells - 1 : static_cast<int>(c));
    }

    std::vector<std::uint32_t> start_;  // first sorted index of each cell, plus one past the end
    std::vector<std::uint32_t> rows_;   // sorted by cell
    std::vector<float> xs_;
    std::vector<float> zs_;
    std::vector<std::uint32_t> cell_of_;  // scratch
    float min_x_ = 0.0F;
    float min_z_ = 0.0F;
    float inverse_cell_ = 1.0F;
    int cells_x_ = 0;
    int cells_z_ = 0;
};

}  // namespace zoned::spatial
