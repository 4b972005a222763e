#include "server/ai/crowd/formation.h"

#include "server/ai/crowd/assignment.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace zoned::ai::steering {

namespace {

double cost_of(std::span<const double> cost,
               std::span<const std::uint32_t> slots,
               std::size_t columns) {
    double sum = 0.0;
    for (std::size_t r = 0; r < slots.size(); ++r) {
        sum += slots[r] == kNoSlot ? 0.0 : cost[r * columns + slots[r]];
    }
    return sum;
}

/// The least cost over all assignments of slots to rows (rows <= slots).
double least_by_all(std::span<const double> cost, std::size_t rows, std::size_t slots) {
    std::vector<std::size_t> order(slots);
    std::iota(order.begin(), order.end(), 0U);
    double least = 1e300;
    do {
        double sum = 0.0;
        for (std::size_t r = 0; r < rows; ++r) {
            sum += cost[r * slots + order[r]];
        }
        least = std::min(least, sum);
    } while (std::next_permutation(order.begin(), order.end()));
    return least;
}

TEST(Assignment, HasTheLeastSumOfCosts) {
    core::Rng rng(1);
    Assignment assignment;
    for (int round = 0; round < 300; ++round) {
        const std::size_t slots = 1 + rng.below(6);
        const std::size_t rows = 1 + rng.below(static_cast<std::uint32_t>(slots));
        std::vector<double> cost(rows * slots);
        for (double& c : cost) {
            // Few values, so that there are ties; some below zero.
            c = static_cast<double>(rng.below(9)) - 2.0;
        }
        const auto got = assignment.solve(cost, rows, slots);
        std::vector<std::uint32_t> sorted(got.begin(), got.end());
        std::sort(sorted.begin(), sorted.end());
        ASSERT_EQ(std::unique(sorted.begin(), sorted.end()), sorted.end());
        ASSERT_LT(sorted.back(), slots);
        ASSERT_DOUBLE_EQ(cost_of(cost, got, slots), least_by_all(cost, rows, slots));
    }
}

TEST(Assignment, LeavesOutWhoCostsMostWhereThereAreTooManyRows) {
    const double cost[] = {5.0, 9.0, 1.0, 2.0, 8.0, 1.5};  // three rows, two slots
    Assignment assignment;
    const auto got = assignment.solve(cost, 3, 2);
    EXPECT_THAT(got, testing::ElementsAre(kNoSlot, 0U, 1U)) << "1 and 1.5, by hand";
}

TEST(Assignment, TakesTheCheapestPairFirstWhereThereAreMany) {
    const std::size_t n = Assignment::kMostExact + 1;
    std::vector<double> cost(n * n, 10.0);
    cost[3 * n + 5] = 1.0;
    cost[3 * n + 6] = 0.5;
    cost[4 * n + 6] = 0.6;
    Assignment assignment;
    const auto got = assignment.solve(cost, n, n);
    EXPECT_EQ(got[3], 6U);
    EXPECT_EQ(got[0], 0U);
    EXPECT_EQ(got[4], 3U) << "6 was taken; of the others the first that is left";
    std::vector<std::uint32_t> sorted(got.begin(), got.end());
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < n; ++i) {
        ASSERT_EQ(sorted[i], i);
    }
}

TEST(PullToSlot, GrowsUpToNearAndFadesBeyond) {
    const FormationSettings settings;
    const Vec2 centre(0.0F, 1.0F);  // m/s
    // 2 m off, within near_m: 1.5 / s times 2 m, and with the centre.
    EXPECT_TRUE(pull_to_slot(settings, centre, {2.0F, 0.0F}).isApprox(Vec2(3.0F, 1.0F), 1e-5F));
    // 9 m off, three times near_m: the pull of near_m, 4.5 m/s, is a third.
    EXPECT_TRUE(pull_to_slot(settings, centre, {9.0F, 0.0F}).isApprox(Vec2(1.5F, 1.0F), 1e-5F));
}

TEST(SlotBeforeWalls, LiesTwoRadiiBeforeTheWall) {
    const Wall wall[] = {{-10.0F, 1.0F, 10.0F, 1.0F}};
    const Walls walls = Walls::make(wall, 2.0F).value();
    // The wall is a quarter of the path.
    EXPECT_TRUE(slot_before_walls(Vec2::Zero(), {0.0F, 4.0F}, 0.25F, walls)
                    .isApprox(Vec2(0.0F, 0.5F), 1e-5F));
    EXPECT_EQ(slot_before_walls(Vec2::Zero(), {0.0F, -4.0F}, 0.25F, walls), Vec2(0.0F, -4.0F))
        << "no wall on this side";
}

}  // namespace

}  // namespace zoned::ai::steering
