#include "server/ai/pathfinding/hierarchy/hpa_cluster_costs.h"

#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/pathfinding/grid_reference.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

namespace zoned::ai::pathfinding {

namespace {

GridMap blocked_map(int width, int height) {
    GridMap map(width, height);
    for (std::uint16_t y = 0; y < height; ++y) {
        for (std::uint16_t x = 0; x < width; ++x) {
            map.set_passable({x, y}, false);
        }
    }
    return map;
}

/// Corridors of one cell, joined at their ends in turn: paths turn at each, up and down or across.
GridMap serpentine(int side, bool upright) {
    GridMap map = blocked_map(side, side);
    for (std::uint16_t a = 0; a < side; ++a) {
        for (std::uint16_t b = 0; b < side; ++b) {
            const bool corridor = a % 2 == 0;
            const bool joint = b == (a / 2 % 2 == 0 ? side - 1 : 0);
            map.set_passable(upright ? Cell{a, b} : Cell{b, a}, corridor || joint);
        }
    }
    return map;
}

std::vector<Cell> some_cells(const GridMap& map,
                             core::Rng& rng,
                             const FlowField::Window& w,
                             std::size_t most) {
    std::vector<Cell> cells;
    for (std::size_t i = 0; i < most; ++i) {
        const Cell c{static_cast<std::uint16_t>(
                         w.left + static_cast<int>(
                                      rng.below(static_cast<std::uint32_t>(w.right - w.left + 1)))),
                     static_cast<std::uint16_t>(
                         w.top + static_cast<int>(
                                     rng.below(static_cast<std::uint32_t>(w.bottom - w.top + 1))))};
        if (map.passable(c)) {
            cells.push_back(c);  // maybe again
        }
    }
    return cells;
}

/// Pairs whose costs differ from those of fields within the square.
std::size_t differing(const GridMap& map,
                      const FlowField::Window& w,
                      const std::vector<Cell>& cells,
                      const std::vector<Cost>& costs) {
    FlowField field;
    std::size_t off = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        field.build(map, cells[i], w);
        for (std::size_t j = 0; j < cells.size(); ++j) {
            off += costs[i * cells.size() + j] != field.cost(map.place(cells[j])) ? 1U : 0U;
        }
    }
    return off;
}

std::vector<Cost> measured(HpaClusterCosts& square,
                           const GridMap& map,
                           const FlowField::Window& w,
                           const std::vector<Cell>& cells) {
    std::vector<Cost> costs(cells.size() * cells.size(), 7);
    square.measure(map,
                   {static_cast<std::uint16_t>(w.left), static_cast<std::uint16_t>(w.top)},
                   w.right - w.left + 1,
                   w.bottom - w.top + 1,
                   cells,
                   costs);
    return costs;
}

TEST(HpaClusterCosts, AreThoseOfAFieldForEachCell) {
    core::Rng rng(7);
    HpaClusterCosts square;
    std::size_t apart = 0;
    std::size_t joined = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        const GridMap map = seed % 5 == 0   ? rooms_map(100, 90, 5, seed)
                            : seed % 5 == 1 ? serpentine(97, seed % 2 == 0)
                                            : random_map(100, 90, 0.08F * (seed % 7), seed);
        const auto side = [&rng] {
            return rng.below(3) == 0 ? 1 + static_cast<int>(rng.below(HpaClusterCosts::kSide))
                                     : HpaClusterCosts::kSide;
        };
        const int width = side();
        const int height = side();
        const int left = static_cast<int>(rng.below(static_cast<std::uint32_t>(91 - width)));
        const int top = static_cast<int>(rng.below(static_cast<std::uint32_t>(91 - height)));
        const FlowField::Window w{left, top, left + width - 1, top + height - 1};
        const std::vector<Cell> cells = some_cells(map, rng, w, rng.below(70));
        const std::vector<Cost> costs = measured(square, map, w, cells);
        ASSERT_EQ(differing(map, w, cells, costs), 0U) << seed;
        for (const Cost c : costs) {
            ++(c == kNoCost ? apart : joined);
        }
    }
    EXPECT_GT(apart, 1000U);
    EXPECT_GT(joined, 10'000U);
}

TEST(HpaClusterCosts, DifferWhereACellHasChanged) {
    GridMap map = serpentine(HpaClusterCosts::kSide, true);
    const FlowField::Window w{0, 0, HpaClusterCosts::kSide - 1, HpaClusterCosts::kSide - 1};
    const std::vector<Cell> cells{{0, 0}, {30, 0}};
    HpaClusterCosts square;
    const std::vector<Cost> costs = measured(square, map, w, cells);
    map.set_passable({15, 16}, true);  // through a wall in the middle
    EXPECT_EQ(differing(map, w, cells, costs), 2U);
}

TEST(HpaClusterCosts, TakeASweepForEachTurnOfAWay) {
    const FlowField::Window w{0, 0, HpaClusterCosts::kSide - 1, HpaClusterCosts::kSide - 1};
    HpaClusterCosts square;
    measured(square, serpentine(HpaClusterCosts::kSide, false), w, {{0, 0}});
    const std::uint64_t downwards = square.work();
    measured(square, serpentine(HpaClusterCosts::kSide, true), w, {{0, 0}});
    // Each row is pulled and spread once, 3 steps a cell at most; upright once for each of 16
    // corridors, and twice more.
    EXPECT_LE(downwards, 2U * 3U * HpaClusterCosts::kSide * HpaClusterCosts::kSide);
    EXPECT_LE(square.work(), (16U + 2U) * 3U * HpaClusterCosts::kSide * HpaClusterCosts::kSide);
}

TEST(HpaClusterCosts, AllocateNothing) {
    const GridMap map = random_map(64, 64, 0.1F, 1);
    const FlowField::Window w{0, 0, HpaClusterCosts::kSide - 1, HpaClusterCosts::kSide - 1};
    core::Rng rng(1);
    const std::vector<Cell> cells = some_cells(map, rng, w, 60);
    std::vector<Cost> costs(cells.size() * cells.size());
    HpaClusterCosts square;
    const std::uint64_t before = allocation_count();
    square.measure(map, {0, 0}, HpaClusterCosts::kSide, HpaClusterCosts::kSide, cells, costs);
    EXPECT_EQ(allocation_count(), before);
}

}  // namespace

}  // namespace zoned::ai::pathfinding
