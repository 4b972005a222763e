#include "server/ai/pathfinding/grid_search/resumable_task.h"

#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "tests/unit/pathfinding/grid_reference.h"

#include <gtest/gtest.h>

namespace zoned::ai::pathfinding {

namespace {

struct Progress {
    int steps = 0;
    int cleared = 0;
};

/// Ten steps of so many units; cancelled, it clears three things up.
ResumableTask ten_steps(std::uint64_t units, Progress& progress) {
    bool cancelled = false;
    for (int i = 0; i < 10 && !cancelled; ++i) {
        ++progress.steps;
        cancelled = co_await Spent{units};
    }
    for (int i = 0; i < 3; ++i) {
        ++progress.cleared;
        co_await Spent{units};
    }
}

TEST(ResumableTask, PayInTheNextCallsForWhatAStepTookBeyondItsUnits) {
    Progress progress;
    ResumableTask work = ten_steps(100, progress);
    std::uint64_t given = 0;
    std::uint64_t taken = 0;
    while (!work.advance(40)) {
        given += 40;
        taken += work.taken();
        ASSERT_LT(taken, given + 100) << "never ahead by more than a step";
        ASSERT_LE(given, taken + 100) << "nor behind";
    }
    EXPECT_EQ(progress.steps, 10);
    EXPECT_EQ(progress.cleared, 3);
    EXPECT_EQ(taken + work.taken(), 1300U);
}

TEST(ResumableTask, ClearUpInPartsOnceTheyAreCancelled) {
    Progress progress;
    ResumableTask work = ten_steps(100, progress);
    ASSERT_FALSE(work.advance(250));
    EXPECT_EQ(progress.steps, 3);
    work.cancel();
    ASSERT_FALSE(work.advance(100 + 50)) << "50 of them are owed";
    EXPECT_EQ(progress.steps, 3);
    EXPECT_EQ(progress.cleared, 1);
    ASSERT_TRUE(work.advance(1000));
    EXPECT_EQ(progress.cleared, 3);
    EXPECT_TRUE(work.advance(1));
}

TEST(GridPlannerInParts, DoNotTryAgainWhatHasExceededItsBoundUntilTheMapIsAnother) {
    IndexBounds bounds;
    bounds.doors = 1000;
    bounds.landmark_bytes = 0;
    GridPlanner planner(rooms_map(120, 100, 11, 1));
    planner.prepare(bounds);
    ASSERT_FALSE(planner.can(GridMethod::kSubgoals));
    const auto turn = [&](int from, int to) {
        std::vector<CellChange> changes;
        for (int x = from; x < to; ++x) {
            const Cell c{static_cast<std::uint16_t>(x % 120), static_cast<std::uint16_t>(x / 120)};
            changes.push_back({c, !planner.map().passable(c)});
        }
        planner.change(changes);
        planner.begin_index(bounds);
        planner.advance_index(~std::uint64_t{0});
        return planner.index_work();
    };
    EXPECT_LT(turn(0, 5), 1000U);
    EXPECT_GT(turn(0, 1000), 100'000U);
    bounds.doors = IndexBounds().doors;
    EXPECT_LT(turn(0, 5), 1000U) << "it does not know that the bound is another";
    turn(0, 1000);
    EXPECT_TRUE(planner.can(GridMethod::kHubLabels));
}

}  // namespace

}  // namespace zoned::ai::pathfinding
