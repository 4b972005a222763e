#include "server/ai/navigation/grid_map.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <bit>

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
    while (runs_[run].parent != run) {
        runs_[run].parent = runs_[runs_[run].parent].parent;
        run = runs_[run].parent;
    }
    return run;
}

void Components::join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    runs_[std::max(a, b)].parent = std::min(a, b);
}

void Components::find_runs(const GridMap& map, int y) {
    const std::span<const std::uint64_t> bits = map.row_bits();
    // The first place at or behind p that is passable, or is not. Behind a row one is blocked.
    const auto seek = [&bits](Place p, Place end, bool passable) {
        while (p < end) {
            const std::uint64_t word = passable ? bits[p >> 6U] : ~bits[p >> 6U];
            const std::uint64_t rest = word >> (p & 63U);
            if (rest != 0) {
                return std::min(end, p + static_cast<Place>(std::countr_zero(rest)));
            }
            p = (p | 63U) + 1;
        }
        return end;
    };
    Place p = map.place({0, static_cast<std::uint16_t>(y)});
    const Place end = p + static_cast<Place>(map.width());
    for (p = seek(p, end, true); p < end; p = seek(p, end, true)) {
        const Place after = seek(p, end, false);
        runs_.push_back({p, after, static_cast<std::uint32_t>(runs_.size())});
        p = after;
    }
}

void Components::label(const GridMap& map) {
    runs_.clear();
    if (mark_.size() != map.places()) {
        mark_.assign(map.places(), 0);  // of the first update(), which has less time
        first_mark_ = 1;
    }
    std::uint32_t above = 0;
    for (int y = 0; y < map.height(); ++y) {
        const auto first = static_cast<std::uint32_t>(runs_.size());
        find_runs(map, y);
        for (std::uint32_t i = first; i < runs_.size(); ++i) {
            const Place begin = runs_[i].begin - map.stride();
            const Place end = runs_[i].end - map.stride();
            while (above < first && runs_[above].end <= begin) {
                ++above;
            }
            for (std::uint32_t j = above; j < first && runs_[j].begin < end; ++j) {
                join(j, i);
            }
        }
        above = first;
    }
    label_.assign(map.places(), 0);
    for (Run& run : runs_) {
        run.parent = runs_[run.parent].parent;  // roots come first: they are final
        std::fill(label_.begin() + run.begin, label_.begin() + run.end, run.parent + 1);
    }
}

}  // namespace zoned::ai::navigation
