// build: computes
#include "server/ai/pathfinding/hierarchy/region_next_hop.h"

#include "tests/unit/pathfinding/grid_reference.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>
#include <utility>
#include <vector>

namespace zoned::ai::pathfinding {

namespace {

Cell any_cell(const GridMap& map, core::Rng& rng) {
    while (true) {
        const Cell c{
            static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.width()))),
            static_cast<std::uint16_t>(rng.below(static_cast<std::uint32_t>(map.height())))};
        if (map.passable(c)) {
            return c;
        }
    }
}

/// Length of the path along the hops until they reach the goal's area. kNoPath where they end
/// before it, go on for ever, or lead through a blocked cell.
double length_to_region(const GridMap& map, const RegionNextHop& regions, Cell c, Cell goal) {
    double length = 0.0;
    for (std::uint32_t steps = 0; steps <= map.passable_cells(); ++steps) {
        const Hop hop = regions.hop(map, c, goal);
        if (hop == kArrived) {
            return length;
        }
        const Cell to = hopped(c, hop);
        if (hop == kNoHop || !map.passable(to) || !map.passable(Cell{to.x, c.y}) ||
            !map.passable(Cell{c.x, to.y})) {
            return kNoPath;
        }
        length += to.x != c.x && to.y != c.y ? std::numbers::sqrt2 : 1.0;
        c = to;
    }
    return kNoPath;
}

void expect_hops_lead_to_goals(const GridMap& map, RegionNextHop& regions, core::Rng& rng) {
    for (int i = 0; i < 5; ++i) {
        const Cell goal = any_cell(map, rng);
        regions.prepare(map, goal);
        const std::vector<double> best = all_lengths(map, goal);
        for (int k = 0; k < 40; ++k) {
            const Cell c = any_cell(map, rng);
            const auto at =
                static_cast<std::size_t>(c.y) * static_cast<std::size_t>(map.width()) + c.x;
            ASSERT_EQ(length_to_region(map, regions, c, goal) == kNoPath, best[at] == kNoPath)
                << c.x << ", " << c.y << " to " << goal.x << ", " << goal.y;
        }
    }
}

TEST(RegionNextHop, LeadFromAnywhereToAnyGoalThatCanBeReached) {
    core::Rng rng(8);
    for (std::uint64_t seed = 1; seed <= 25; ++seed) {
        const GridMap map =
            seed % 2 == 0 ? rooms_map(130, 101, 11, seed) : random_map(101, 130, 0.36F, seed);
        RegionNextHop regions(map);
        expect_hops_lead_to_goals(map, regions, rng);
    }
}

TEST(RegionNextHop, AreAfterChangesWhatTheyWouldBeAnew) {
    core::Rng rng(9);
    GridMap map = rooms_map(130, 101, 11, 4);
    RegionNextHop regions(map);
    for (int round = 0; round < 40; ++round) {
        std::vector<CellChange> changes;
        for (int i = 0; i < 6; ++i) {
            const Cell c{static_cast<std::uint16_t>(rng.below(130)),
                         static_cast<std::uint16_t>(rng.below(101))};
            changes.push_back({c, !map.passable(c)});
            map.set_passable(c, changes.back().passable);
        }
        regions.update(map, changes);
        RegionNextHop anew(map);
        ASSERT_EQ(regions.regions(), anew.regions());
        for (int i = 0; i < 200; ++i) {
            const Cell goal = any_cell(map, rng);
            const Cell c = any_cell(map, rng);
            regions.prepare(map, goal);
            anew.prepare(map, goal);
            ASSERT_EQ(regions.hop(map, c, goal), anew.hop(map, c, goal));
        }
    }
}

TEST(RegionNextHop, KeepTheTablesOfTheLastGoalsAndAnswerForAll) {
    core::Rng rng(11);
    constexpr std::size_t kKept = 40;
    const GridMap map = rooms_map(240, 240, 13, 3);
    RegionNextHop regions(map, kKept);
    ASSERT_GT(regions.regions(), 3 * kKept);
    RegionNextHop all(map, regions.regions());
    while (all.lacks_tables()) {
        all.prepare_next(0);
    }
    for (std::uint64_t tick = 1; tick <= 600; ++tick) {
        const Cell goal = any_cell(map, rng);
        regions.prepare(map, goal, {tick, tick});
        for (int i = 0; i < 10; ++i) {
            const Cell c = any_cell(map, rng);
            ASSERT_EQ(regions.hop(map, c, goal), all.hop(map, c, goal)) << tick;
            ASSERT_EQ(regions.cells(map, c, goal), all.cells(map, c, goal)) << tick;
        }
    }
    const auto tables = [](const RegionNextHop& of) {
        std::vector<std::pair<Cell, std::uint64_t>> all;
        of.visit_tables([&all](Cell c, std::uint64_t used) { all.emplace_back(c, used); });
        return all;
    };
    std::vector<Cell> middles;
    regions.visit_middles([&middles](Cell c) { middles.push_back(c); });
    for (std::uint64_t i = 0; i < middles.size(); ++i) {
        regions.prepare(map, middles[i], {1000 + i, 1000 + i});
    }
    // The last ones, each with the tick of its use.
    EXPECT_EQ(tables(regions).size(), kKept);
    for (const auto& [cell, used] : tables(regions)) {
        EXPECT_GE(used, 1000 + middles.size() - kKept);
    }
    // A copy made of what is saved replaces the same ones.
    RegionNextHop copy(map, kKept);
    for (const auto& [cell, used] : tables(regions)) {
        copy.prepare(map, cell, {used, 0});
    }
    for (std::uint64_t tick = 3000; tick < 3200; ++tick) {
        const Cell goal = any_cell(map, rng);
        const bool was_made = regions.prepare(map, goal, {tick, tick - 5});
        ASSERT_EQ(copy.prepare(map, goal, {tick, tick - 5}), was_made) << tick;
        ASSERT_EQ(tables(copy), tables(regions)) << tick;
    }
    // Tables that are needed stay, however many.
    for (const Cell c : middles) {
        regions.prepare(map, c, {4000, 4000});
    }
    EXPECT_TRUE(std::all_of(
        middles.begin(), middles.end(), [&](Cell c) { return regions.prepared(map, c); }));
}

TEST(RegionNextHop, LeadAlongWaysThatAreNotFarFromTheBest) {
    core::Rng rng(10);
    const GridMap map = rooms_map(256, 256, 13, 2);
    RegionNextHop regions(map);
    double sum = 0.0;
    double sum_best = 0.0;
    for (int i = 0; i < 40; ++i) {
        const Cell goal = any_cell(map, rng);
        regions.prepare(map, goal);
        const std::vector<double> best = all_lengths(map, goal);
        for (int k = 0; k < 40; ++k) {
            const Cell c = any_cell(map, rng);
            const auto at = static_cast<std::size_t>(c.y) * 256 + c.x;
            if (best[at] != kNoPath && best[at] > 100.0) {
                sum += length_to_region(map, regions, c, goal);
                sum_best += best[at];
            }
        }
    }
    // Up to the goal's area alone, so that the best would be a little less than 1.
    EXPECT_LT(sum / sum_best, 1.25);
    EXPECT_GT(sum / sum_best, 0.85);
}

}  // namespace

}  // namespace zoned::ai::pathfinding
