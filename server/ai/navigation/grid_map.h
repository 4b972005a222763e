// GridMap: which cells of a regular grid can be walked, as bits in rows and in columns.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::navigation {

struct Cell {
    std::uint16_t x = 0;  ///< column, from the left
    std::uint16_t y = 0;  ///< row, from the top

    friend bool operator==(const Cell&, const Cell&) = default;
};

/// Number of a cell in arrays over a map, which have a border of blocked cells around it: so
/// neighbours of cells need no check of bounds, nor has the word of bits before them.
using Place = std::uint32_t;

inline constexpr Place kNoPlace = ~Place{0};

/// A cell that changes.
struct CellChange {
    Cell cell;
    bool passable = false;
};

/// Steps go to eight neighbours, those along a diagonal only where both cells beside it are
/// passable too (no cutting of corners).
class GridMap {
  public:
    static constexpr int kMaxSide = 8192;  ///< cells

    /// All blocked. 1 <= width, height <= kMaxSide.
    GridMap(int width, int height);

    [[nodiscard]] int width() const { return width_; }

    [[nodiscard]] int height() const { return height_; }

    [[nodiscard]] std::uint32_t passable_cells() const { return passable_cells_; }

    /// Places are smaller than this.
    [[nodiscard]] std::uint32_t places() const { return stride_ * rows_; }

    /// From a place to the one below it.
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

    /// `c` is on the map.
    void set_passable(Cell c, bool passable);

    /// Bit p is set where place p is passable; rows begin at whole words.
    [[nodiscard]] std::span<const std::uint64_t> row_bits() const { return by_row_; }

    /// The same turned over: bit column_place(c) is set where c is passable.
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

/// Which cells can reach which. Without cutting corners a diagonal step can be walked in two
/// straight ones as well, so that cells which touch by their sides tell all.
class Components {
  public:
    /// Takes the map as it is, in time linear in its places (runs of passable cells, joined from
    /// row to row; Rosenfeld and Pfaltz, "Sequential operations in digital picture processing",
    /// 1966).
    void label(const GridMap& map);

    /// After `changes` were made to the map that was labelled, some of which may be none. What is
    /// opened joins its neighbours; around what is closed floods from all sides run side by side
    /// until they meet or one is shut in (Shiloach and Even, "An on-line edge-deletion problem",
    /// Journal of the ACM 28, 1981): a door costs as much as the smaller side of it, or the way
    /// round. Labels all anew where that would be dearer.
    void update(const GridMap& map, std::span<const CellChange> changes);

    /// 0 for a blocked place, else a number that places share exactly where one reaches the other.
    [[nodiscard]] std::uint32_t of(Place p) const {
        std::uint32_t label = label_[p];
        if (label != 0) {
            while (runs_[label - 1].parent != label - 1) {
                label = runs_[label - 1].parent + 1;
            }
        }
        return label;
    }

  private:
    /// What is reached from a cell beside those that were closed.
    struct Flood {
        std::vector<Place> cells;
        std::size_t looked_at = 0;
        std::uint32_t joined = 0;  ///< flood that this one has met, no later; itself at a root
        std::uint32_t label = 0;   ///< that its cells had
        bool shut = false;
    };

    void open(const GridMap& map, Place p);
    bool split(const GridMap& map);
    void add_flood(Place p);
    void spread(const GridMap& map, std::uint32_t flood);
    [[nodiscard]] std::uint32_t flood_root(std::uint32_t flood) const;
    bool part(std::uint32_t label);

    /// Passable cells of a row, `end` behind them.
    struct Run {
        Place begin;
        Place end;
        std::uint32_t parent;  ///< a run joined with this one, no later; itself at a root
    };

    std::uint32_t root(std::uint32_t run);
    void join(std::uint32_t a, std::uint32_t b);
    void find_runs(const GridMap& map, int y);

    std::vector<std::uint32_t> label_;  // by place
    std::vector<Run> runs_;
    std::vector<Flood> floods_;  // the first `flood_count_` of them
    std::uint32_t flood_count_ = 0;
    std::vector<std::uint32_t> mark_;  // by place: flood that has reached it, from first_mark_ on
    std::uint32_t first_mark_ = 1;
    std::uint32_t flooded_ = 0;
};

}  // namespace zoned::ai::navigation
