// KeptGrid: a uniform grid over points in the x-z plane that follows points which move, come and go
// without being rebuilt, and may remember where each was a tick ago.
#pragma once

#include "server/spatial/box_lanes.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace zoned::interest {

/// Points and their radii by key (0 .. size - 1). A point without a positive radius is no point.
struct GridPoints {
    std::span<const float> x;      ///< m, finite where the radius is positive
    std::span<const float> z;      ///< likewise
    std::span<const float> old_x;  ///< a tick ago, m; as long as `x`, or empty
    std::span<const float> old_z;
    std::span<const float> radius_m;
};

/// A place in the plane, now and a tick ago, m.
struct Stride {
    float x = 0.0F;
    float z = 0.0F;
    float old_x = 0.0F;
    float old_z = 0.0F;
};

/// Cells stand in one row of slots, line by line, so that a query reads a few long runs. Every
/// fourth cell has a spare slot at first; a cell that is full borrows one from a neighbour, as in a
/// packed memory array (Bender, Demaine and Farach-Colton, "Cache-oblivious B-trees", SIAM Journal
/// on Computing 35, 2005, section 2). Empty slots hold what is not a number and fail every
/// comparison. The order within a cell depends on the past; nobody may depend on it.
class KeptGrid {
  public:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

    /// Indexes all points afresh, in cells that are `cell_m` > 0 deep and half as wide; they grow
    /// where the extent would need more than 1,048,576 of them. Without places a tick ago the grid
    /// does not remember any.
    void build(const GridPoints& points, float cell_m);

    [[nodiscard]] bool holds(std::uint32_t key) const { return slot_of_[key] != kNone; }

    /// Keys up to `keys` exist, new ones without a point.
    void resize(std::size_t keys) { slot_of_.resize(keys, kNone); }

    /// Where the point was before is its place a tick ago, until settle(). False where no slot is
    /// free nearby: then the grid has to be built anew, and the point is not in it.
    bool move(std::uint32_t key, float x, float z);
    /// False as in move().
    bool put(std::uint32_t key, const Stride& at, float radius_m);
    void take(std::uint32_t key);

    [[nodiscard]] float radius_m(std::uint32_t key) const { return radius_[slot_of_[key]]; }

    /// Calls visit(key) for all points, cell by cell.
    template <class Visit>
    void for_each_key(Visit&& visit) const {
        for (std::size_t c = 0; c < counts_.size(); ++c) {
            for (std::uint32_t i = begins_[c]; i < begins_[c] + counts_[c]; ++i) {
                visit(keys_[i]);
            }
        }
    }

    /// Neighbours in the plane have slots near each other.
    [[nodiscard]] std::uint32_t slot(std::uint32_t key) const { return slot_of_[key]; }

    [[nodiscard]] std::size_t slots() const { return keys_.size(); }

    [[nodiscard]] bool remembers() const { return !old_x_.empty(); }

    /// Line of cells that a point lies in, from 0.
    [[nodiscard]] std::uint32_t line_of(float z) const {
        return static_cast<std::uint32_t>(line(z));
    }

    /// From now on the point was a tick ago where it is.
    void settle(std::uint32_t key);

    [[nodiscard]] float cell_m() const { return cell_m_; }

    /// True where so many points lie beyond the extent of the last build() that queries suffer.
    [[nodiscard]] bool worn() const { return outside_ > 64 + slot_of_.size() / 16; }

    /// Appends to `out` the keys but `own` of all points within min(radius, their radius) x `widen`
    /// of (x, z), closed, in the arithmetic of hears(). `out` has room for keys() + 8.
    std::size_t gather(float x,
                       float z,
                       float radius_m,
                       float widen,
                       std::uint32_t own,
                       std::uint32_t* out) const;

    [[nodiscard]] std::size_t keys() const { return slot_of_.size(); }

    /// Calls visit(begin, end) for runs of slots that hold all points of a box, closed, m.
    template <class Visit>
    void for_each_run(float x0, float x1, float z0, float z1, Visit&& visit) const {
        if (counts_.empty()) {
            return;
        }
        const int first = column(x0);
        const int last = column(x1);
        const int bottom = line(z0);
        const int top = line(z1);
        for (int cz = bottom; cz <= top; ++cz) {
            const std::size_t row = static_cast<std::size_t>(cz) * columns_;
            const std::size_t right = row + static_cast<std::size_t>(last);
            visit(begins_[row + static_cast<std::size_t>(first)], begins_[right + 1]);
        }
    }

    /// Calls visit(key) for points in a run for which one of the comparisons of `test` came out
    /// otherwise a tick ago; see Crossings. With `kRemember` a point has moved as the grid
    /// remembers, else it is where it was.
    template <bool kRemember, class Test, class Visit>
    void for_each_crossed(std::uint32_t begin,
                          std::uint32_t end,
                          const Test& test,
                          Visit&& visit) const {
        for (std::uint32_t i = begin; i < end; i += spatial::kLanes) {
            const spatial::Array8 x = load(x_, i);
            const spatial::Array8 z = load(z_, i);
            std::uint32_t mask = 0;
            if constexpr (kRemember) {
                mask = test(x, z, load(old_x_, i), load(old_z_, i), load(radius_, i));
            } else {
                mask = test(x, z, x, z, load(radius_, i));
            }
            if (end - i < spatial::kLanes) {
                mask &= (1U << (end - i)) - 1U;
            }
            for (; mask != 0; mask &= mask - 1) {
                visit(keys_[i + static_cast<std::uint32_t>(std::countr_zero(mask))]);
            }
        }
    }

  private:
    static spatial::Array8 load(const std::vector<float>& column, std::uint32_t i) {
        return Eigen::Map<const spatial::Array8>(column.data() + i);
    }

    [[nodiscard]] int column(float x) const { return place(x, min_x_, per_m_x_, last_column_); }

    [[nodiscard]] int line(float z) const { return place(z, min_z_, per_m_z_, last_line_); }

    /// Monotonic, so that no rounding parts a point from a query that holds it.
    static int place(float at, float origin, float per_m, float last) {
        const float cells = (at - origin) * per_m;
        return static_cast<int>(cells > 0.0F ? (cells < last ? cells : last) : 0.0F);
    }

    [[nodiscard]] std::uint32_t cell(float x, float z) const {
        return static_cast<std::uint32_t>(line(z)) * static_cast<std::uint32_t>(columns_) +
               static_cast<std::uint32_t>(column(x));
    }

    void choose_cells(const GridPoints& points, float cell_m);
    void count_points(const GridPoints& points);
    void fill(const GridPoints& points);
    bool make_room(std::uint32_t cell);
    void move_slot(std::uint32_t from, std::uint32_t to);
    void clear_slot(std::uint32_t slot);

    std::vector<std::uint32_t> begins_;  // first slot of each cell, and one past the end
    std::vector<std::uint32_t> counts_;  // points in each cell; its slots may be more
    std::vector<float> x_;
    std::vector<float> z_;
    std::vector<float> old_x_;
    std::vector<float> old_z_;
    std::vector<float> radius_;
    std::vector<std::uint32_t> keys_;
    std::vector<std::uint32_t> slot_of_;  // by key
    std::vector<std::uint32_t> cell_of_;  // by key, scratch of build()
    std::size_t columns_ = 0;
    std::size_t outside_ = 0;  // points put beyond the extent since build()
    float cell_m_ = 0.0F;
    float per_m_x_ = 0.0F;
    float per_m_z_ = 0.0F;
    float min_x_ = 0.0F;
    float min_z_ = 0.0F;
    float max_x_ = 0.0F;
    float max_z_ = 0.0F;
    float last_column_ = 0.0F;
    float last_line_ = 0.0F;
};

}  // namespace zoned::interest
