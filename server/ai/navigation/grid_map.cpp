#include "server/ai/navigation/grid_map.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai::navigation {

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

std::uint32_t Components::root(std::uint32_t run) {
    while (parent_[run] != run) {
        parent_[run] = parent_[parent_[run]];
        run = parent_[run];
    }
    return run;
}

void Components::join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    if (a != b) {
        parent_[std::max(a, b)] = std::min(a, b);
    }
}

void Components::label(const GridMap& map) {
    label_.assign(map.places(), 0);
    parent_.assign(1, 0);
    const std::uint32_t stride = map.stride();
    for (int y = 0; y < map.height(); ++y) {
        const Place first = map.place({0, static_cast<std::uint16_t>(y)});
        std::uint32_t run = 0;
        for (Place p = first; p < first + static_cast<std::uint32_t>(map.width()); ++p) {
            if (!map.passable(p)) {
                run = 0;
                continue;
            }
            const std::uint32_t above = label_[p - stride];
            if (run == 0) {
                run = above != 0 ? above : static_cast<std::uint32_t>(parent_.size());
                if (above == 0) {
                    parent_.push_back(run);
                }
            } else if (above != 0 && above != run) {
                join(above, run);
            }
            label_[p] = run;
        }
    }
    for (std::uint32_t i = 1; i < parent_.size(); ++i) {
        parent_[i] = parent_[parent_[i]];  // roots have the smallest numbers: they are final
    }
    for (std::uint32_t& l : label_) {
        l = parent_[l];
    }
}

}  // namespace zoned::ai::navigation
