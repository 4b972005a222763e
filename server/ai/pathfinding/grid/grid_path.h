// GridPath: corners of a path on a grid, put together segment by segment.
#pragma once

#include "server/ai/pathfinding/grid/grid_query.h"

#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// The cells at which a path turns, with its first and last cell. Between two of them it runs along
/// a row, a column or a diagonal.
class GridPath {
  public:
    void begin(Cell start) {
        corners_.clear();
        corners_.push_back(start);
        straight_ = 0;
        diagonal_ = 0;
    }

    /// Goes on to `to`: along the diagonal first, then straight.
    void go(Cell to);

    /// Goes on to `to` by the reverse of go() from there: straight first, then the diagonal.
    void arrive(Cell to);

    /// Reserves room for so many corners without an allocation.
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

/// Lists all cells of a path from its corners, start and goal included.
void cells_of(std::span<const Cell> corners, std::vector<Cell>& cells);

/// True where the path along the diagonal first and then straight is free: no best path is shorter.
bool free_line(const GridMap& map, Cell from, Cell to);

}  // namespace zoned::ai::pathfinding
