// PointGrid: a uniform grid over points in the x-z plane, built by counting sort whenever it is
// needed.
#pragma once

#include "shared/math/types.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::spatial {

/// Answers "which points lie near here". No allocation after warm-up. This is the grid for points.
/// Other grids serve boxes (box_grid.h), a radius for each point (interest/incremental_grid.h),
/// three dimensions (physics/soft/collision/self_collision.cpp) and a layout for devices
/// (FlockOrder).
///
/// Points that rest can be kept from build to build: then a build costs only the loose points, and
/// a query looks into two grids.
class PointGrid {
  public:
    /// Indexes `points` (rows are their positions in the span) afresh. `cell_m` > 0; cells grow
    /// where the extent would need more than 4,194,304 of them. Points that are not finite are left
    /// out.
    void build(std::span<const Vec3> points, float cell_m);

    /// Indexes the points of `rows` until they are loose in follow(), and no others.
    void keep(std::span<const Vec3> points, std::span<const std::uint32_t> rows, float cell_m);

    /// All points but those that are kept are among `loose`. A kept point that is loose now, or
    /// beyond the end of `points`, is kept no more. Costs as much as there are loose ones.
    void follow(std::span<const Vec3> points, std::span<const std::uint32_t> loose, float cell_m);

    /// Calls `visit(row, distance_squared)` for each point within `radius` (m, closed) of (x, z),
    /// horizontally; the order is the same for the same calls before.
    template <class Visit>
    void for_each_within(float x, float z, float radius, Visit&& visit) const {
        kept_.for_each_within(x, z, radius, visit);
        loose_.for_each_within(x, z, radius, visit);
    }

    [[nodiscard]] std::size_t size() const { return kept_points_ + loose_.rows.size(); }

    /// Visits have an order that follows from earlier calls, so all of it is saved.
    template <class Archive>
    void serialize(Archive& archive) {
        for (GridLayer* const layer : {&kept_, &loose_}) {
            archive(layer->start, layer->rows, layer->xs, layer->zs, layer->min_x, layer->min_z);
            archive(layer->inverse_cell, layer->cells_x, layer->cells_z);
        }
        archive(kept_at_, kept_points_);
    }

  private:
    /// One grid: by cell, then in the order of the build.
    struct GridLayer {
        template <class RowAt>
        void build(std::span<const Vec3> points, std::size_t count, RowAt&& row_at, float cell_m);

        template <class Visit>
        void for_each_within(float x, float z, float radius, Visit&& visit) const {
            if (rows.empty()) {
                return;
            }
            const float r2 = radius * radius;
            // A little wider than the radius, because the differences below are rounded. A point a
            // rounding outside the radius, in the next cell, may count as within it.
            const float reach_x = radius + 1e-6F * (radius + std::abs(x));
            const float reach_z = radius + 1e-6F * (radius + std::abs(z));
            const int x0 = cell(x - reach_x, min_x, cells_x);
            const int x1 = cell(x + reach_x, min_x, cells_x);
            const int z0 = cell(z - reach_z, min_z, cells_z);
            const int z1 = cell(z + reach_z, min_z, cells_z);
            for (int cz = z0; cz <= z1; ++cz) {
                const std::size_t line =
                    static_cast<std::size_t>(cz) * static_cast<std::size_t>(cells_x);
                const std::uint32_t end = start[line + static_cast<std::size_t>(x1) + 1];
                for (std::uint32_t i = start[line + static_cast<std::size_t>(x0)]; i < end; ++i) {
                    const float dx = xs[i] - x;
                    const float dz = zs[i] - z;
                    const float d2 = dx * dx + dz * dz;
                    // A point that is no more here has no position, which is no number.
                    if (d2 <= r2) {
                        visit(rows[i], d2);
                    }
                }
            }
        }

        [[nodiscard]] int cell(float coordinate, float origin, int cells) const {
            const float c = (coordinate - origin) * inverse_cell;
            // Also zero for NaN: a query there finds nothing.
            return !(c > 0.0F) ? 0
                               : (c >= static_cast<float>(cells) ? cells - 1 : static_cast<int>(c));
        }

        std::vector<std::uint32_t> start;  // first sorted index of each cell, plus one past the end
        std::vector<std::uint32_t> rows;   // sorted by cell
        std::vector<float> xs;
        std::vector<float> zs;
        std::vector<std::uint32_t> cell_of;  // scratch
        float min_x = 0.0F;
        float min_z = 0.0F;
        float inverse_cell = 1.0F;
        int cells_x = 0;
        int cells_z = 0;
    };

    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

    void forget(std::uint32_t row);

    GridLayer kept_;
    GridLayer loose_;
    std::vector<std::uint32_t> kept_at_;  // by row: index into the columns of kept_, or kNone
    std::size_t kept_points_ = 0;
};

}  // namespace zoned::spatial
