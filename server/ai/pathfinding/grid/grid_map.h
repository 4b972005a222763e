// GridMap: the passable cells of a regular grid, as bits in rows and in columns.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

struct Cell {
    std::uint16_t x = 0;  ///< column, from the left
    std::uint16_t y = 0;  ///< row, from the top

    friend bool operator==(const Cell&, const Cell&) = default;
};

/// The number of a cell in arrays over a map. These arrays have a border of blocked cells around
/// the map. So neighbours of cells need no check of bounds, and the word of bits before them needs
/// none.
using Place = std::uint32_t;

inline constexpr Place kNoPlace = ~Place{0};

/// A cell that changes.
struct CellChange {
    Cell cell;
    bool passable = false;
};

/// Steps go to eight neighbours. A diagonal step needs both cells beside it passable too (no
/// cutting of corners).
class GridMap {
  public:
    static constexpr int kMaxSide = 8192;  ///< cells

    /// Makes a map with all cells blocked. 1 <= width, height <= kMaxSide.
    GridMap(int width, int height);

    [[nodiscard]] int width() const { return width_; }

    [[nodiscard]] int height() const { return height_; }

    [[nodiscard]] std::uint32_t passable_cells() const { return passable_cells_; }

    /// Upper bound of places, exclusive.
    [[nodiscard]] std::uint32_t places() const { return stride_ * rows_; }

    /// The distance from a place to the one below it.
    [[nodiscard]] std::uint32_t stride() const { return stride_; }

    [[nodiscard]] bool contains(Cell c) const { return c.x < width_ && c.y < height_; }

    [[nodiscard]] Place place(Cell c) const { return (c.y + 2U) * stride_ + c.x + 1U; }

    [[nodiscard]] Cell cell(Place p) const {
        return {static_cast<std::uint16_t>(p % stride_ - 1),
                static_cast<std::uint16_t>(p / stride_ - 2)};
    }

    [[nodiscard]] bool passable(Place p) const { return (by_row_[p >> 6U] >> (p & 63U) & 1U) != 0; }

    /// False off the map.
    [[nodiscard]] bool passable(Cell c) const { return contains(c) && passable(place(c)); }

    /// True if so many cells of a row are passable, from `first` on. All must be on the map.
    [[nodiscard]] bool all_passable(Cell first, int cells) const;

    /// `c` must be on the map.
    void set_passable(Cell c, bool passable);

    /// Sets all cells at once. Bit place(c) says whether c is passable; all others are 0. As many
    /// words as row_bits() has.
    void set_all(std::span<const std::uint64_t> row_bits);

    /// Bit p is set where place p is passable; rows begin at whole words.
    [[nodiscard]] std::span<const std::uint64_t> row_bits() const { return by_row_; }

    /// The same transposed: bit column_place(c) is set where c is passable.
    [[nodiscard]] std::span<const std::uint64_t> column_bits() const { return by_column_; }

    [[nodiscard]] std::uint32_t column_place(Cell c) const {
        return (c.x + 2U) * column_stride_ + c.y + 1U;
    }

    [[nodiscard]] std::uint32_t column_stride() const { return column_stride_; }

  private:
    int width_;
    int height_;
    std::uint32_t stride_;
    std::uint32_t rows_;
    std::uint32_t column_stride_;
    std::uint32_t passable_cells_ = 0;
    std::vector<std::uint64_t> by_row_;
    std::vector<std::uint64_t> by_column_;
};

}  // namespace zoned::ai::pathfinding
