#include "server/ai/pathfinding/hierarchy/hpa_cluster_costs.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <bit>

namespace zoned::ai::pathfinding {

namespace {

constexpr std::int32_t kStraightStep = kStraight;
constexpr std::int32_t kDiagonalStep = kDiagonal;
/// More than any path within a square costs; with steps on top no overflow.
constexpr std::int32_t kUnreachedCost = 1 << 30;
static_assert(HpaClusterCosts::kSide * HpaClusterCosts::kSide * kDiagonalStep < kUnreachedCost);
static_assert(kernels::kLanes * sizeof(std::int32_t) == sizeof(kernels::LaneInts));

kernels::LaneInts less_of(const kernels::LaneInts& a, const kernels::LaneInts& b) {
    return a < b ? a : b;
}

}  // namespace

void HpaClusterCosts::measure(const GridMap& map,
                              Cell corner,
                              int width,
                              int height,
                              std::span<const Cell> cells,
                              std::span<Cost> costs) {
    ZONED_ASSERT(width >= 1 && width <= kSide && height >= 1 && height <= kSide, "a small square");
    ZONED_ASSERT(costs.size() == cells.size() * cells.size(), "room for all pairs");
    work_ = 0;
    take_rows(map, corner, width, height);
    const std::size_t n = cells.size();
    for (std::size_t first = 0; first < n; first += kAtOnce) {
        const std::size_t count = std::min(kAtOnce, n - first);
        std::fill_n(costs_.begin(),
                    static_cast<std::ptrdiff_t>(height) * kSide,
                    Costs{{Lanes{} + kUnreachedCost, Lanes{} + kUnreachedCost}});
        for (std::size_t i = 0; i < count; ++i) {
            const Cell c = cells[first + i];
            at(c.x - corner.x, c.y - corner.y).of[i / kernels::kLanes][i % kernels::kLanes] = 0;
            tells_down_[static_cast<std::size_t>(c.y - corner.y)] = true;
        }
        settle(height);
        for (std::size_t j = 0; j < n; ++j) {
            const Costs& there = at(cells[j].x - corner.x, cells[j].y - corner.y);
            for (std::size_t i = 0; i < count; ++i) {
                const std::int32_t cost = there.of[i / kernels::kLanes][i % kernels::kLanes];
                costs[(first + i) * n + j] =
                    cost < kUnreachedCost ? static_cast<Cost>(cost) : kNoCost;
            }
        }
    }
}

void HpaClusterCosts::take_rows(const GridMap& map, Cell corner, int width, int height) {
    for (int y = 0; y < height; ++y) {
        const Place first = map.place({corner.x, static_cast<std::uint16_t>(corner.y + y)});
        const std::uint64_t* const word = map.row_bits().data() + (first >> 6U);
        const std::uint32_t shift = first & 63U;
        std::uint64_t bits = word[0] >> shift;
        if (shift > 32) {
            bits |= word[1] << (64 - shift);
        }
        const std::uint64_t within = (std::uint64_t{1} << static_cast<unsigned>(width)) - 1;
        rows_[static_cast<std::size_t>(y)] = static_cast<std::uint32_t>(bits & within);
    }
}

/// Starts from the rows that have cells to begin with; these notify the rows below.
void HpaClusterCosts::settle(int height) {
    tells_up_.fill(false);
    for (int y = 0; y < height; ++y) {
        const auto row = static_cast<std::size_t>(y);
        if (tells_down_[row]) {
            spread(y);
            tells_up_[row] = true;
        }
    }
    // The last row of a sweep notifies no row.
    const auto sweep = [&](int first, int end, int step, auto& tells) {
        bool changed = false;
        for (int y = first; y != end; y += step) {
            bool& told = tells[static_cast<std::size_t>(y)];
            if (told && pull(y + step, y)) {
                spread(y + step);
                tells_down_[static_cast<std::size_t>(y + step)] = true;
                tells_up_[static_cast<std::size_t>(y + step)] = true;
                changed = true;
            }
            told = false;
        }
        tells[static_cast<std::size_t>(end)] = false;
        return changed;
    };
    bool down = true;
    bool up = true;
    while (down || up) {
        down = sweep(0, height - 1, 1, tells_down_);
        up = sweep(height - 1, 0, -1, tells_up_);
    }
}

/// A row from one beside it; whether anything got cheaper. Diagonal steps need all four cells.
bool HpaClusterCosts::pull(int y, int from) {
    const std::uint32_t straight =
        rows_[static_cast<std::size_t>(y)] & rows_[static_cast<std::size_t>(from)];
    const std::uint32_t from_left = straight & straight << 1U;
    const std::uint32_t from_right = straight & straight >> 1U;
    Costs gained{};
    for (std::uint32_t rest = straight; rest != 0; rest &= rest - 1) {
        const int x = std::countr_zero(rest);
        const std::uint32_t bit = rest & -rest;
        const Costs* const beside = &at(x, from);
        Costs& own = at(x, y);
        for (std::size_t k = 0; k < own.of.size(); ++k) {
            Lanes least = beside[0].of[k] + kStraightStep;
            if ((from_left & bit) != 0) {
                least = less_of(least, beside[-1].of[k] + kDiagonalStep);
            }
            if ((from_right & bit) != 0) {
                least = less_of(least, beside[1].of[k] + kDiagonalStep);
            }
            const Lanes was = own.of[k];
            own.of[k] = less_of(was, least);
            gained.of[k] |= was - own.of[k];
        }
    }
    work_ += static_cast<std::uint64_t>(std::popcount(straight));
    Lanes any{};
    for (const Lanes& g : gained.of) {
        any |= g;
    }
    std::int32_t gain = 0;
    for (std::size_t i = 0; i < kernels::kLanes; ++i) {
        gain |= any[i];
    }
    return gain != 0;
}

/// Along a row, to the right and to the left.
void HpaClusterCosts::spread(int y) {
    const std::uint32_t row = rows_[static_cast<std::size_t>(y)];
    const std::uint32_t pairs = row & row << 1U;  // the right one of each
    for (std::uint32_t rest = pairs; rest != 0; rest &= rest - 1) {
        const int x = std::countr_zero(rest);
        step_along(at(x, y), at(x - 1, y));
    }
    for (std::uint32_t rest = pairs; rest != 0;) {
        const int x = 31 - std::countl_zero(rest);
        step_along(at(x - 1, y), at(x, y));
        rest ^= 1U << static_cast<unsigned>(x);
    }
    work_ += 2U * static_cast<std::uint64_t>(std::popcount(pairs));
}

void HpaClusterCosts::step_along(Costs& to, const Costs& from) {
    for (std::size_t k = 0; k < to.of.size(); ++k) {
        to.of[k] = less_of(to.of[k], from.of[k] + kStraightStep);
    }
}

}  // namespace zoned::ai::pathfinding
