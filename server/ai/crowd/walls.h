// Walls: the static geometry of a crowd, as line segments on the ground in a grid.
#pragma once

#include "server/spatial/cell_lists.h"
#include "shared/core/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::steering {

/// A wall without thickness from a to b, m.
struct Wall {
    float ax, az, bx, bz;
};

/// Walls by cells. Long ones are cut into pieces, so that each lies in few cells. It has its own
/// grid beside spatial::BoxGrid, whose boxes move: these lists are written once and then only read.
class Walls {
  public:
    /// Holds no walls.
    Walls() = default;

    /// `cell_m` > 0: about the distance at which agents look for walls. Cells grow where there
    /// would be more than kMostCells. Fails for a wall that is not finite or longer than kLongest;
    /// the error names it.
    static core::Result<Walls> make(std::span<const Wall> walls, float cell_m);

    static constexpr std::size_t kMostCells = 1U << 20U;
    static constexpr float kLongest = 1e5F;  ///< m, the largest length and the largest distance
                                             ///< from the origin

    [[nodiscard]] bool empty() const { return pieces_.empty(); }

    [[nodiscard]] std::span<const Wall> pieces() const { return pieces_; }

    /// Calls visit(wall) once for each piece whose cells touch the box (m): for all pieces within
    /// it, and some more. The order is the same for the same walls.
    template <class Visit>
    void for_each_near(float low_x, float low_z, float high_x, float high_z, Visit&& visit) const {
        if (pieces_.empty()) {
            return;
        }
        const int x0 = column(low_x);
        const int x1 = column(high_x);
        const int z0 = row(low_z);
        const int z1 = row(high_z);
        for (int cz = z0; cz <= z1; ++cz) {
            for (int cx = x0; cx <= x1; ++cx) {
                const auto cell = static_cast<std::size_t>(cz * columns_ + cx);
                for (const std::uint32_t i : inside_.of(cell)) {
                    const Wall& w = pieces_[i];
                    // Visits a piece only in the first cell that the box and the piece's own box
                    // share.
                    const float left = w.ax < w.bx ? w.ax : w.bx;
                    const float top = w.az < w.bz ? w.az : w.bz;
                    const int first_x = column(left);
                    const int first_z = row(top);
                    if (cx == (first_x > x0 ? first_x : x0) &&
                        cz == (first_z > z0 ? first_z : z0)) {
                        visit(w);
                    }
                }
            }
        }
    }

  private:
    [[nodiscard]] int column(float x) const { return clamped((x - low_x_) * per_m_, columns_); }

    [[nodiscard]] int row(float z) const { return clamped((z - low_z_) * per_m_, rows_); }

    /// A coordinate that is not a number counts to the first cell.
    static int clamped(float at, int count) {
        return !(at > 0.0F)
                   ? 0
                   : (at < static_cast<float>(count - 1) ? static_cast<int>(at) : count - 1);
    }

    void lay_cells(float cell_m);
    void fill_cells();

    std::vector<Wall> pieces_;
    spatial::CellLists inside_;  // pieces whose own box touches the cell
    float low_x_ = 0.0F;
    float low_z_ = 0.0F;
    float per_m_ = 1.0F;
    int columns_ = 0;
    int rows_ = 0;
};

}  // namespace zoned::ai::steering
