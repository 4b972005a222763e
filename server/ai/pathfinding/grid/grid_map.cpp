#include "server/ai/pathfinding/grid/grid_map.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <array>
#include <bit>

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

using Block = std::array<std::uint64_t, 64>;

/// Bit i of word j becomes bit j of word i. Source: Warren, "Hacker's Delight", 7-3.
void transpose(Block& block) {
    std::uint64_t mask = 0xFFFFFFFF;
    for (unsigned half = 32; half != 0; half >>= 1U, mask ^= mask << half) {
        for (unsigned i = 0; i < block.size(); i = (i + half + 1) & ~half) {
            const std::uint64_t swapped = (block[i] >> half ^ block[i + half]) & mask;
            block[i] ^= swapped << half;
            block[i + half] ^= swapped;
        }
    }
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

bool GridMap::all_passable(Cell first, int cells) const {
    const Place end = place(first) + static_cast<Place>(cells);
    for (Place p = place(first); p < end;) {
        const Place next = std::min(end, (p | 63U) + 1);
        const std::uint64_t all = ~std::uint64_t{0} >> (64U - (next - p)) << (p & 63U);
        if ((by_row_[p >> 6U] & all) != all) {
            return false;
        }
        p = next;
    }
    return true;
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

void GridMap::set_all(std::span<const std::uint64_t> row_bits) {
    ZONED_ASSERT(row_bits.size() == by_row_.size(), "bits of a map of another size");
    std::copy(row_bits.begin(), row_bits.end(), by_row_.begin());
    passable_cells_ = 0;
    for (const std::uint64_t word : by_row_) {
        passable_cells_ += static_cast<std::uint32_t>(std::popcount(word));
    }
    // In blocks that are whole words of both: the first column and the first row of the border come
    // first.
    const std::uint32_t across = stride_ / 64;
    const std::uint32_t down = column_stride_ / 64;
    const auto columns = static_cast<std::uint32_t>(width_);
    Block block;
    for (std::uint32_t w = 0; w < across; ++w) {
        for (std::uint32_t v = 0; v < down; ++v) {
            for (std::uint32_t i = 0; i < block.size(); ++i) {
                const std::uint32_t row = v * 64 + i + 1;
                block[i] = row < rows_ ? by_row_[row * across + w] : 0;
            }
            transpose(block);
            for (std::uint32_t j = w == 0 ? 1 : 0; j < block.size() && w * 64 + j <= columns; ++j) {
                by_column_[(w * 64 + j + 1) * down + v] = block[j];
            }
        }
    }
}

}  // namespace zoned::ai::pathfinding
