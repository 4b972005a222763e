#include "server/ai/pathfinding/flow_fields/flow_field.h"

#include "tests/unit/allocation_count.h"
#include "tests/unit/pathfinding/grid_reference.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <numbers>

namespace zoned::ai::pathfinding {

namespace {

/// Length of the path along the hops from `c`; kNoPath where they end elsewhere than at `goal`.
template <class HopAt>
double followed(const GridMap& map, Cell c, Cell goal, const HopAt& hop_at) {
    std::vector<Cell> corners{c};
    double length = 0.0;
    for (std::uint32_t steps = 0; steps <= map.passable_cells(); ++steps) {
        const Hop hop = hop_at(c);
        if (hop >= kArrived) {
            const bool there = hop == kArrived && c == goal;
            return there && wrong_with(map, corners.front(), goal, length, corners).empty()
                       ? length
                       : kNoPath;
        }
        const Cell to = hopped(c, hop);
        length += to.x != c.x && to.y != c.y ? std::numbers::sqrt2 : 1.0;
        corners.push_back(to);
        c = to;
    }
    return kNoPath;
}

void expect_best_hops(const GridMap& map, Cell goal) {
    FlowField field;
    field.build(map, goal);
    const std::vector<double> lengths = all_lengths(map, goal);
    std::size_t i = 0;
    for (std::uint16_t y = 0; y < map.height(); ++y) {
        for (std::uint16_t x = 0; x < map.width(); ++x, ++i) {
            const Cell c{x, y};
            const Place p = map.place(c);
            if (lengths[i] == kNoPath || !map.passable(c)) {
                ASSERT_EQ(field.hop(p), kNoHop);
                ASSERT_EQ(field.cost(p), kNoCost);
                continue;
            }
            // 3.7e-7 a diagonal (cost.h), at most some 2,000 of them here.
            ASSERT_NEAR(field.cost(p) / double{kStraight}, lengths[i], 1e-3);
            ASSERT_NEAR(followed(map, c, goal, [&](Cell at) { return field.hop(map.place(at)); }),
                        lengths[i],
                        1e-3);
        }
    }
}

TEST(FlowField, LeadsFromEachCellAlongABestWay) {
    core::Rng rng(1);
    for (std::uint64_t seed = 1; seed <= 25; ++seed) {
        const GridMap map = random_map(1 + static_cast<int>(rng.below(70)),
                                       1 + static_cast<int>(rng.below(40)),
                                       0.04F * static_cast<float>(seed % 10),
                                       seed);
        for (int n = 0; n < 3; ++n) {
            const Cell goal{
                static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.width()))),
                static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.height())))};
            if (map.passable(goal)) {
                expect_best_hops(map, goal);
            }
        }
    }
    expect_best_hops(rooms_map(90, 70, 8, 1), {9, 9});
}

TEST(FlowField, OfABlockedGoalLeadsNowhere) {
    const GridMap map = map_of({"...", ".#.", "..."});
    FlowField field;
    field.build(map, {1, 1});
    EXPECT_EQ(field.hop(map.place({0, 0})), kNoHop);
    EXPECT_EQ(field.cost(map.place({1, 1})), kNoCost);
}

TEST(FlowField, AllocatesNothingForAnotherGoal) {
    const GridMap map = rooms_map(128, 128, 8, 3);
    FlowField field;
    field.build(map, {1, 1});
    const std::uint64_t before = allocation_count();
    field.build(map, {100, 101});
    EXPECT_EQ(allocation_count(), before);
}

}  // namespace

}  // namespace zoned::ai::pathfinding
