// HpaClusterCosts: the best costs between some cells of a small square, all at once.
#pragma once

#include "server/ai/pathfinding/grid/cost.h"
#include "server/ai/pathfinding/grid/grid_map.h"
#include "kernels/include/kernel_base.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// Costs from several cells are columns that are looked at together, kAtOnce of them: what a cell
/// costs is the least of what its neighbours cost and the step from there, which is asked of row
/// after row downwards and upwards until nothing gets cheaper (the sweeps of Zhao, "A fast sweeping
/// method for Eikonal equations", Mathematics of Computation 74, 2005, for which on a graph the
/// bound of Bellman and Ford holds; costs are whole, so that the end is exact). Sweeps needed are
/// the turns between down and up of a best path, and two: rows are looked at again only where the
/// one that leads to them has changed.
class HpaClusterCosts {
  public:
    static constexpr int kSide = 32;  ///< cells, at most
    static constexpr std::size_t kAtOnce = 2 * kernels::kLanes;

    HpaClusterCosts() : costs_(kSide * kSide) {}

    /// Of best paths between `cells`, each passable, that stay within the rectangle from (left,
    /// top) on: row by row into `costs`, which has room for the square of their number. kNoCost
    /// where there is none. 1 <= width, height <= kSide. Allocates nothing.
    void measure(const GridMap& map,
                 Cell corner,
                 int width,
                 int height,
                 std::span<const Cell> cells,
                 std::span<Cost> costs);

    /// Steps along a row or column, or from row to row, that the last measure() has looked at, each
    /// for kAtOnce cells: its measure of work.
    [[nodiscard]] std::uint64_t work() const { return work_; }

  private:
    using Lanes = kernels::LaneInts;

    struct Costs {
        std::array<Lanes, kAtOnce / kernels::kLanes> of;
    };

    [[nodiscard]] Costs& at(int x, int y) {
        return costs_[static_cast<std::size_t>(y * kSide + x)];
    }

    void take_rows(const GridMap& map, Cell corner, int width, int height);
    void settle(int height);
    bool pull(int y, int from);
    void spread(int y);
    void step_along(Costs& to, const Costs& from);

    std::array<std::uint32_t, kSide> rows_{};  // passable cells, as bits
    std::vector<Costs> costs_;
    std::array<bool, kSide> tells_down_{};  // has changed since the row below has looked
    std::array<bool, kSide> tells_up_{};
    std::uint64_t work_ = 0;
};

}  // namespace zoned::ai::pathfinding
