// CrowdOrder: the agents of a crowd sorted by cells, so that neighbours lie side by side.
#pragma once

#include "server/ai/crowd/crowd_agents.h"
#include "server/compute/team.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::ai::steering {

/// The columns that a step reads of an agent, in the order of cells.
enum SortedColumn : std::size_t {
    kSortedX,
    kSortedZ,
    kSortedVx,
    kSortedVz,
    kSortedRadius,
    kSortedYield,
    kSortedPathLeft,
    kSortedWantX,
    kSortedWantZ,
    kSortedSpeed,
    kSortedColumns
};

/// Up to eight agents that are processed together: neighbours in the sorted order, in one row of
/// cells.
struct CrowdBatch {
    std::uint32_t begin, end;  ///< range of sorted agents
    int first_cell, last_cell;
    int row;
};

/// CrowdOrder has its own grid beside spatial::PointGrid. It copies the columns of all agents into
/// the order of cells, so that eight lanes load neighbours as a run. It is rebuilt in each step.
class CrowdOrder {
  public:
    /// Sorts (stable, by counting) into cells of `cell_m` (> 0). The cells are larger where there
    /// would be more than kMostCells. Agents whose position is not a number count to the first
    /// cell. Does not allocate for numbers of agents and cells met before.
    void sort(const CrowdAgents& agents, float cell_m, compute::Team& team);

    static constexpr std::size_t kMostCells = 1U << 18U;

    [[nodiscard]] const float* column(SortedColumn c) const { return sorted_[c].data(); }

    /// The row of the agent at each sorted place.
    [[nodiscard]] const std::vector<std::uint32_t>& rows() const { return rows_; }

    [[nodiscard]] const std::vector<CrowdBatch>& batches() const { return batches_; }

    /// Sorted places [first, second) of the agents in row `row` of cells from one column to
    /// another, both included. Columns beyond the grid count as its rim; rows beyond it are empty.
    [[nodiscard]] std::array<std::uint32_t, 2> stretch(int row, int first, int last) const {
        if (row < 0 || row >= cell_rows_) {
            return {0, 0};
        }
        const int from = first > 0 ? first : 0;
        const int to = last < columns_ ? last : columns_ - 1;
        const auto line = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_);
        return {begin_[line + static_cast<std::size_t>(from)],
                begin_[line + static_cast<std::size_t>(to) + 1]};
    }

  private:
    void lay_grid(const CrowdAgents& agents, float cell_m);
    void make_batches();

    float low_x_ = 0.0F;
    float low_z_ = 0.0F;
    float per_m_ = 1.0F;
    int columns_ = 1;
    int cell_rows_ = 1;
    std::array<std::vector<float>, kSortedColumns> sorted_;
    std::vector<std::uint32_t> cell_of_;
    std::vector<std::uint32_t> rows_;
    std::vector<std::uint32_t> begin_;
    std::vector<CrowdBatch> batches_;
};

}  // namespace zoned::ai::steering
