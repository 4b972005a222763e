// HpaClusterCosts: measures the best costs between some cells of a small square, all at once.
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

/// Costs from several cells are columns, and kAtOnce of them are processed together. The cost of a
/// cell is the least sum of a neighbour's cost and the step from there. Row after row is computed
/// downwards and upwards until no cost falls. Source for the sweeps: Zhao, "A fast sweeping method
/// for Eikonal equations", Mathematics of Computation 74, 2005. On a graph the bound of Bellman and
/// Ford holds for them; costs are whole, so the end is exact. The number of sweeps is two more than
/// the turns of a best path between down and up. A row is computed again only where the row that
/// leads to it has changed.
class HpaClusterCosts {
  public:
    static constexpr int kSide = 32;  ///< side of the square, cells, at most
    static constexpr std::size_t kAtOnce = 2 * kernels::kLanes;

    HpaClusterCosts() : costs_(kSide * kSide) {}

    /// Measures the costs of best paths between `cells`, each passable, that stay within the
    /// rectangle from (left, top) on. They are written row by row into `costs`, which has room for
    /// the square of their number. kNoCost where there is no path. 1 <= width, height <= kSide.
    /// Allocates nothing.
    void measure(const GridMap& map,
                 Cell corner,
                 int width,
                 int height,
                 std::span<const Cell> cells,
                 std::span<Cost> costs);

    /// Steps along a row or column, or from row to row, that the last measure() has looked at, each
    /// for kAtOnce cells. It is the measure of work.
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
    std::array<bool, kSide> tells_down_{};  // the row has changed since the row below was computed
    std::array<bool, kSide> tells_up_{};
    std::uint64_t work_ = 0;
};

}  // namespace zoned::ai::pathfinding
