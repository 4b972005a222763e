#include "server/ai/pathfinding/grid/grid_map.h"

#include "shared/core/assert.h"

namespace zoned::ai::pathfinding {

namespace {

/// Room for `side` cells and a border, in whole words.
std::uint32_t padded(int side) {
    return (static_cast<std::uint32_t>(side) + 2U + 63U) & ~63U;
}

void set_bit(std::vector<std::uint64_t>& bits, std::uint32_t at, bool value) {
    const std::uint64_t bit = std::uint64_t{1} << (at & 63U);
    bits[at >> 6U] = value ? bits[at >> 6U] | bit : bits[at >> 6U] & ~bit;
}

}  // namespace

GridMap::GridMap(int width, int height)
    : width_(width),
      height_(height),
      stride_(padded(width)),
      rows_(static_cast<std::uint32_t>(height) + 3U),
      column_stride_(padded(height)) {
    ZONED_ASSERT(width >= 1 && width <= kMaxSide && height >= 1 && height <= kMaxSide,
                 "a grid has 1 to kMaxSide cells each way");
    // A word more, for readers of unaligned words.
    by_row_.assign(std::size_t{stride_} * rows_ / 64 + 1, 0);
    by_column_.assign(
        std::size_t{column_stride_} * (static_cast<std::uint32_t>(width) + 3U) / 64 + 1, 0);
}

void GridMap::set_passable(Cell c, bool passable) {
    ZONED_ASSERT(contains(c), "a cell off the map");
    const Place p = place(c);
    if (this->passable(p) == passable) {
        return;
    }
    passable_cells_ += passable ? 1U : ~0U;
    set_bit(by_row_, p, passable);
    set_bit(by_column_, column_place(c), passable);
}

}  // namespace zoned::ai::pathfinding
