#include "server/ai/learning/arena.h"

#include "server/ai/learning/evolution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace zoned::ai::learning {
namespace {

TEST(Arena, WalkingStraightReachesGoalsAndRunsIntoTheWall) {
    const ArenaResult result = play({}, nullptr, core::Rng(3, 1));
    EXPECT_GT(result.reached, 3);
    EXPECT_GT(result.wall_s, 1.0F);
    EXPECT_LT(result.mean_off_m, 20.0F);
}

TEST(Arena, WhoStandsReachesNextToNothingAndTouchesNoWall) {
    const Policy still =
        arena_policy({}, dense(std::array<std::size_t, 2>{5, 2}));  // all weights 0
    const ArenaResult result = play({}, &still, core::Rng(3, 1));
    EXPECT_LT(result.reached, 3);
    EXPECT_EQ(result.wall_s, 0.0F);
}

TEST(Arena, PoliciesLearnToReachTheGoalAndToKeepOutOfTheWall) {
    const ArenaTask task;
    FixedTopology fixed;
    fixed.shape = dense(std::array<std::size_t, 3>{5, 8, 2});
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        Evolution evolution(task, fixed, seed);
        for (int generation = 0; generation < 40; ++generation) {
            evolution.step(run_here);
        }
        const Policy policy = arena_policy(task.arena(), evolution.best());
        constexpr int kEpisodes = 100;  // that no training saw: another stream of numbers
        double more = 0.0;
        double squares = 0.0;
        float wall = 0.0F;
        float straight_wall = 0.0F;
        for (std::uint64_t e = 0; e < kEpisodes; ++e) {
            const ArenaResult learned = play(task.arena(), &policy, core::Rng(e, 9));
            const ArenaResult straight = play(task.arena(), nullptr, core::Rng(e, 9));
            const double difference = learned.points() - straight.points();
            more += difference / kEpisodes;
            squares += difference * difference / kEpisodes;
            wall += learned.wall_s / kEpisodes;
            straight_wall += straight.wall_s / kEpisodes;
        }
        std::printf("seed %d: %.2f points more; at the wall %.2f s, straight %.2f s\n",
                    static_cast<int>(seed),
                    more,
                    static_cast<double>(wall),
                    static_cast<double>(straight_wall));
        // Beyond chance: four standard errors of a mean of differences on the same episodes.
        EXPECT_GT(more, 4.0 * std::sqrt((squares - more * more) / kEpisodes));
        EXPECT_LT(wall, 0.2F * straight_wall);
    }
}

}  // namespace
}  // namespace zoned::ai::learning
