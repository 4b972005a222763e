// GridPath: corners of a path on a grid, put together segment by segment.
#pragma once

#include "server/ai/pathfinding/grid/grid_query.h"

#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// Cells at which a path turns, with its first and last cell: between neighbours it runs along a
/// row, a column or a diagonal.
class GridPath {
  public:
    void begin(Cell start) {
        corners_.clear();
        corners_.push_back(start);
        straight_ = 0;
        diagonal_ = 0;
    }

    /// On to `to`: along the diagonal first, then straight.
    void go(Cell to);

    /// On to `to` along what go() would take from there back: straight first, then the diagonal.
    void arrive(Cell to);

    /// So many corners have room without an allocation.
    void reserve(std::size_t corners) { corners_.reserve(corners); }

    [[nodiscard]] std::span<const Cell> corners() const { return corners_; }

    [[nodiscard]] double length() const { return length_of(straight_, diagonal_); }

    [[nodiscard]] Cost cost() const { return straight_ * kStraight + diagonal_ * kDiagonal; }

  private:
    void segment(Cell to);

    std::vector<Cell> corners_;
    std::uint32_t straight_ = 0;
    std::uint32_t diagonal_ = 0;
};

/// All cells of a path from its corners, start and goal among them.
void cells_of(std::span<const Cell> corners, std::vector<Cell>& cells);

/// True where the path along the diagonal first and then straight is free: no best path is shorter.
bool free_line(const GridMap& map, Cell from, Cell to);

}  // namespace zoned::ai::pathfinding
