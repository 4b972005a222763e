// Components: the connected parts of a grid map, kept up to date as cells change.
#pragma once

#include "server/ai/pathfinding/grid/grid_map.h"
#include "shared/core/containers/union_find.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace zoned::ai::pathfinding {

/// Corners are never cut, so a diagonal step can also be walked in two straight ones. Cells that
/// touch by their sides therefore decide what is connected.
///
/// The map is cut into squares of 64 cells. Cells of a square that reach each other within it are a
/// region. Regions are found by runs of passable cells that are joined from row to row; regions
/// that touch across a border of squares are joined likewise. Source: Rosenfeld and Pfaltz,
/// "Sequential operations in digital picture processing", Journal of the ACM 13, 1966.
///
/// A change costs the squares that it touches and a look at all regions. There are few regions on
/// any map. A door on 512 x 512 cells costs below 0.1 ms, mazes and scattered obstacles included.
class Components {
  public:
    /// Labels the map from scratch, in time linear in its places.
    void label(const GridMap& map);

    /// Updates after `changes` to the labelled map; some changes may leave a cell as it was.
    void update(const GridMap& map, std::span<const CellChange> changes);

    /// 0 for a blocked place. Else a number; places share it exactly where one reaches the other.
    [[nodiscard]] std::uint32_t of(Place p) const {
        const std::uint32_t label = label_[p];
        return label == 0 ? 0 : 1 + root_[region(label)];
    }

    /// Upper bound of of(), exclusive.
    [[nodiscard]] std::uint32_t numbers() const {
        return static_cast<std::uint32_t>(root_.size()) + 1;
    }

    /// True if the last update() joined this passable place's component from parts that were apart
    /// before.
    [[nodiscard]] bool joined_anew(Place p) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    /// A square and, in the low bits, the number of a region in it; plus 1, so that 0 is blocked.
    using Label = std::uint32_t;

    static constexpr unsigned kSideBits = 6;
    /// A square has at most one region for every second cell.
    static constexpr unsigned kRegionBits = 2 * kSideBits - 1;

    /// Run: adjacent passable cells in a row of a square.
    struct Run {
        std::uint64_t cells;
        std::uint16_t row;
        std::uint16_t region;
    };

    [[nodiscard]] std::uint32_t region(Label label) const {
        const std::uint32_t at = label - 1;
        return first_region_[at >> kRegionBits] + (at & ((1U << kRegionBits) - 1));
    }

    [[nodiscard]] std::uint32_t square_of(Place p) const;
    void label_square(const GridMap& map, std::uint32_t square);
    void find_runs(const GridMap& map, std::uint32_t square);
    void link_square(std::uint32_t square);
    void join_regions();

    std::uint32_t stride_ = 0;
    std::uint32_t rows_ = 0;
    std::uint32_t across_ = 0;                 // squares
    std::vector<Label> label_;                 // by place
    std::vector<std::uint32_t> regions_;       // by square, number of its regions
    std::vector<std::uint32_t> first_region_;  // by square, and one more
    std::vector<std::uint32_t> root_;          // by region: the first region that it reaches
    /// By square: regions that touch across its right side and its lower side.
    std::vector<std::vector<std::pair<Label, Label>>> links_;
    std::vector<Run> runs_;
    core::UnionFind joined_runs_;
    core::UnionFind joined_regions_;
    std::vector<std::uint8_t> stale_;  // by square, during an update
    std::vector<std::uint32_t> stale_squares_;
    std::vector<std::pair<Place, std::uint32_t>> beside_;  // opened cells, and the regions that
                                                           // they touch
    std::vector<std::uint32_t> joined_;                    // by the last update(), ascending
};

}  // namespace zoned::ai::pathfinding
