#include "server/ai/pathfinding/flow_fields/crowd_paths.h"

#include "server/ai/pathfinding/grid/line_of_sight.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/pathfinding/grid_reference.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace zoned::ai::pathfinding {

namespace {

Cell cell_in(int x, int y) {
    return {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
}

/// 60 x 40 cells of half a metre, with a wall in the middle that has gaps of 4 cells in rows 4 and
/// 30.
GridMap two_gaps() {
    GridMap map(60, 40);
    for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 60; ++x) {
            const bool gap = (y >= 4 && y < 8) || (y >= 30 && y < 34);
            map.set_passable(cell_in(x, y), x != 30 || gap);
        }
    }
    return map;
}

const GroundGrid& half_metres() {
    static const GroundGrid grid({0.0F, 0.0F, 30.0F, 20.0F}, 0.5F);
    return grid;
}

/// Until all fields are up to date.
void settle(CrowdPaths& paths) {
    for (int tick = 0; tick < 1000; ++tick) {
        paths.advance();
    }
}

/// The row in which a path comes through the wall.
int gap_of(const std::vector<Cell>& cells) {
    for (std::size_t i = 1; i < cells.size(); ++i) {
        const Cell a = cells[i - 1];
        const Cell b = cells[i];
        if ((a.x < 30) != (b.x < 30) || a.x == 30 || b.x == 30) {
            return a.x == 30 ? a.y : b.y;
        }
    }
    return -1;
}

class TwoGaps : public testing::Test {
  protected:
    TwoGaps() : paths(two_gaps(), half_metres(), settings()) {}

    static CrowdPathSettings settings() {
        CrowdPathSettings out;
        out.remember = 0.5F;
        out.jam_per_m2 = 1.6F;
        out.work_per_tick = 20'000;
        return out;
    }

    std::vector<Cell> path() {
        std::vector<Cell> cells{start};
        EXPECT_TRUE(paths.append_path(start, goal, cells));
        return cells;
    }

    /// So many bodies in the 2 x 2 m of the first gap: 4 cells at a tenth of the speed are longer
    /// by 36 cells, the other gap by 25.
    void crowd(int bodies) {
        std::vector<float> x;
        std::vector<float> z;
        for (int i = 0; i < bodies; ++i) {
            x.push_back(14.1F + 1.8F * static_cast<float>(i) / static_cast<float>(bodies));
            z.push_back(2.5F + static_cast<float>(i % 3) * 0.5F);
        }
        for (int look = 0; look < 12; ++look) {
            settle(paths);
            ASSERT_TRUE(paths.looks());
            paths.look(x, z);
        }
        settle(paths);
    }

    CrowdPaths paths;
    Cell start = cell_in(10, 6);
    Cell goal = cell_in(50, 6);
};

TEST_F(TwoGaps, AWayLeadsAroundACrowdAndBackWhereItIsGone) {
    std::vector<Cell> cells{start};
    EXPECT_FALSE(paths.append_path(start, goal, cells)) << "nobody has asked so far";
    settle(paths);
    EXPECT_LT(gap_of(path()), 8);
    const CrowdPaths::Cost free = paths.cost(start, goal);
    // 20 m along the row.
    EXPECT_EQ(free, CrowdPaths::Cost{40} * kStraight * 2 * kPerStep);
    EXPECT_EQ(paths.cost_along({5.25F, 3.25F}, {25.25F, 3.25F}), free);
    crowd(14);
    EXPECT_GE(gap_of(path()), 30);
    EXPECT_GT(paths.cost(start, goal), free);
    // It pays the stated cost: straight on costs more.
    EXPECT_LT(paths.cost(start, goal), paths.cost_along({5.25F, 3.25F}, {25.25F, 3.25F}));
    std::uint32_t looked = 0;
    EXPECT_FALSE(sees(paths.calm(), start, goal, looked));
    crowd(0);
    EXPECT_LT(gap_of(path()), 8);
    EXPECT_EQ(paths.cost(start, goal), free);
}

TEST_F(TwoGaps, AreShownWithTheStepsOfTheirField) {
    EXPECT_FALSE(paths.field_to(goal));
    std::vector<Cell> cells{start};
    EXPECT_FALSE(paths.append_path(start, goal, cells));
    EXPECT_FALSE(paths.field_to(goal)) << "it is not made yet";
    settle(paths);
    crowd(14);
    const auto field = paths.field_to(goal);
    ASSERT_TRUE(field);
    std::vector<Cell> shown{start};
    while (paths.hop(*field, shown.back()) < kArrived && shown.size() < 1000) {
        shown.push_back(hopped(shown.back(), paths.hop(*field, shown.back())));
    }
    EXPECT_EQ(shown.back(), goal);
    EXPECT_GE(gap_of(shown), 30) << "around the crowd";
}

TEST_F(TwoGaps, AWayEndsAtAClosedDoorAtOnceAndIsThereAgainSoon) {
    std::vector<Cell> cells{start};
    EXPECT_FALSE(paths.append_path(start, goal, cells));
    settle(paths);
    std::vector<CellChange> shut;
    for (int y = 4; y < 8; ++y) {
        shut.push_back({cell_in(30, y), false});
    }
    paths.change(shut);
    cells.assign(1, start);
    EXPECT_FALSE(paths.append_path(start, goal, cells));
    EXPECT_EQ(cells.size(), 1U);
    settle(paths);
    EXPECT_GE(gap_of(path()), 30);
}

/// A tick's work is as much as it was given, but for the copy of a finished field.
TEST_F(TwoGaps, WorksInSlices) {
    std::vector<Cell> cells{start};
    EXPECT_FALSE(paths.append_path(start, goal, cells));
    int ticks = 0;
    for (; paths.cost(start, goal) == CrowdFlowField::kNoPath; ++ticks) {
        EXPECT_LE(paths.advance(), settings().work_per_tick + 2 * two_gaps().places());
        ASSERT_LT(ticks, 1000);
    }
    // 2368 cells at 75 units, 20,000 a tick.
    EXPECT_GE(ticks, 8);
    EXPECT_LE(ticks, 12);
}

TEST_F(TwoGaps, AreRememberedWithTheSameWays) {
    std::vector<Cell> cells{start};
    EXPECT_FALSE(paths.append_path(start, goal, cells));
    settle(paths);
    crowd(14);
    const SavedCrowds memory = paths.save();
    CrowdPaths other(two_gaps(), half_metres(), settings());
    ASSERT_TRUE(other.load(memory));
    const GridMap map = two_gaps();
    for (int y = 0; y < 40; y += 3) {
        for (int x = 0; x < 60; x += 7) {
            const Cell from = cell_in(x, y);
            if (!map.passable(from)) {
                continue;
            }
            EXPECT_EQ(other.cost(from, goal), paths.cost(from, goal));
            std::vector<Cell> a{from};
            std::vector<Cell> b{from};
            EXPECT_TRUE(paths.append_path(from, goal, a));
            EXPECT_TRUE(other.append_path(from, goal, b));
            EXPECT_EQ(a, b);
        }
    }
    for (const auto spoil : {0, 1, 2, 3}) {
        SavedCrowds bad = memory;
        ASSERT_FALSE(bad.blocks.empty());
        spoil == 0   ? bad.blocks[0].block = 1'000'000
        : spoil == 1 ? bad.goals[0].place = 1'000'000
        : spoil == 2 ? (bad.goals.pop_back(), 0U)
                     : (bad.blocks.push_back(bad.blocks[0]), 0U);
        CrowdPaths none(two_gaps(), half_metres(), settings());
        EXPECT_FALSE(none.load(bad)) << spoil;
    }
}

TEST_F(TwoGaps, AllocatesNothingOnceWarm) {
    std::vector<Cell> cells{start};
    EXPECT_FALSE(paths.append_path(start, goal, cells));
    settle(paths);
    std::vector<float> x(20, 13.0F);
    std::vector<float> z(20, 3.0F);
    const auto round = [&] {
        for (const float at : {13.0F, 3.0F, 17.0F, 13.0F}) {
            std::fill(x.begin(), x.end(), at);
            settle(paths);
            paths.look(x, z);
        }
        settle(paths);
    };
    round();
    round();
    const std::uint64_t before = allocation_count();
    round();
    EXPECT_EQ(allocation_count(), before);
}

/// A field that is made and brought up to date a few cells at a time is the one that is made at
/// once.
TEST(CrowdFlowFieldInParts, IsTheSame) {
    core::Rng rng(8);
    GridMap map = random_map(40, 30, 0.2F, 5);
    const Cell goal = cell_in(20, 15);
    map.set_passable(goal, true);
    std::vector<Crowding> crowding(map.places(), 0);
    CrowdFlowField sliced;
    CrowdFlowField whole;
    sliced.begin_build(map, goal);
    whole.build(map, crowding, goal);
    for (int round = 0; round < 40; ++round) {
        int resumable_task = 1;
        while (!sliced.advance(map, crowding, 1 + rng.below(9))) {
            ++resumable_task;
        }
        for (Place p = 0; p < map.places(); ++p) {
            ASSERT_EQ(sliced.cost(p), whole.cost(p)) << "round " << round;
        }
        std::vector<Place> changed;
        for (int i = 0; i < 5; ++i) {
            const Place p = map.place(
                cell_in(static_cast<int>(rng.below(40)), static_cast<int>(rng.below(30))));
            crowding[p] = static_cast<Crowding>(rng.below(200));
            changed.push_back(p);
        }
        EXPECT_GT(resumable_task, round == 0 ? 50 : 0);
        sliced.begin_update(changed);
        whole.build(map, crowding, goal);
    }
}

TEST(DensityInBlocks, CountsByWhatIsPassable) {
    GridMap map(8, 8);
    for (int y = 0; y < 8; ++y) {
        for (int x = 0; x < 8; ++x) {
            map.set_passable(cell_in(x, y), x < 6);
        }
    }
    DensitySettings settings;
    settings.cell_m = 0.5F;
    settings.remember = 0.0F;
    settings.block = 4;
    Density density(map, settings);
    const std::vector<float> x{2.2F, 2.8F, 0.3F};
    const std::vector<float> z{0.2F, 1.7F, 0.3F};
    density.look(x, z);
    // Two on the 2 m2 that are passable of the second block, one on the 4 m2 of the first.
    EXPECT_FLOAT_EQ(density.of(map.place(cell_in(4, 0))), 1.0F);
    EXPECT_FLOAT_EQ(density.of(map.place(cell_in(0, 3))), 0.25F);
    EXPECT_FLOAT_EQ(density.of(map.place(cell_in(0, 4))), 0.0F);
    EXPECT_EQ(density.crowding()[map.place(cell_in(5, 3))],
              density.crowding()[map.place(cell_in(4, 0))]);
    EXPECT_EQ(density.changed().size(), 16U) << "the one in the first block is no crowd";
    density.look({}, {});
    EXPECT_FLOAT_EQ(density.of(map.place(cell_in(4, 0))), 0.0F);
}

}  // namespace

}  // namespace zoned::ai::pathfinding
