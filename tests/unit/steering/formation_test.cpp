#include "server/ai/crowd/formation.h"

#include "server/ai/crowd/orca_avoidance.h"
#include "server/ai/pathfinding/grid_search/grid_planner.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string_view>

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

std::vector<FormationSlot> wedge() {
    return {{0.0F, 0.0F}, {-1.5F, 1.5F}, {-1.5F, -1.5F}, {-3.0F, 3.0F}, {-3.0F, -3.0F}};
}

const Formation::Route kStraightOn = [](std::size_t, const Vec2&, const Vec2& to) {
    return to;
};

TEST(Formation, PullsAsItSays) {
    CrowdAgents agents;
    agents.add(1, 0.0F, 0.0F, 0.25F, 50.0F);
    const std::size_t members[] = {0};
    FormationSettings settings;
    settings.straggler_m = 100.0F;
    Formation one({{2.0F, 1.0F}}, settings);
    // Looks along z: ahead is z, right is -x.
    one.place({10.0F, 0.0F}, {0.0F, 1.0F}, {0.0F, 1.0F});
    one.enlist(agents, members);
    const Vec2 slot = one.slot_of(0, Walls(), 0.25F);
    EXPECT_TRUE(slot.isApprox(Vec2(9.0F, 2.0F), 1e-6F));
    // 2 m off, within near_m: 1.5 / s times 2 m, and with the centre.
    agents.x[0] = 7.0F;
    agents.z[0] = 2.0F;
    one.aim(agents, Walls(), kStraightOn);
    EXPECT_NEAR(agents.want_x[0], 3.0F, 1e-5F);
    EXPECT_NEAR(agents.want_z[0], 1.0F, 1e-5F);
    // 9 m off, three times near_m: the pull of near_m, 4.5 m/s, is a third.
    agents.x[0] = 0.0F;
    one.aim(agents, Walls(), kStraightOn);
    EXPECT_NEAR(agents.want_x[0], 1.5F, 1e-5F);
}

TEST(Formation, GivesSlotsSoThatNobodyCrosses) {
    CrowdAgents agents;
    const float rows[][2] = {{-4, -4}, {-4, 4}, {1, 0}, {-2, 2}, {-2, -2}};
    for (std::uint32_t i = 0; i < 5; ++i) {
        agents.add(i, rows[i][0], rows[i][1], 0.25F, 2.0F);
    }
    const std::size_t members[] = {0, 1, 2, 3, 4};
    Formation group(wedge(), {});
    group.place(Vec2::Zero(), Vec2::Zero(), {1.0F, 0.0F});
    group.enlist(agents, members);
    // Right of +x is +z.
    const Vec2 by_hand[] = {{-3, -3}, {-3, 3}, {0, 0}, {-1.5F, 1.5F}, {-1.5F, -1.5F}};
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_TRUE(group.slot_of(i, Walls(), 0.25F).isApprox(by_hand[i], 1e-5F) ||
                    (by_hand[i].norm() == 0.0F && group.slot_of(i, Walls(), 0.25F).norm() < 1e-5F))
            << i;
    }
}

TEST(Formation, MovesSlotsBeforeWalls) {
    const Wall wall[] = {{-10.0F, 1.0F, 10.0F, 1.0F}};
    const Walls walls = Walls::make(wall, 2.0F).value();
    CrowdAgents agents;
    agents.add(0, 0.0F, 0.0F, 0.25F, 2.0F);
    const std::size_t members[] = {0};
    Formation group({{0.0F, 4.0F}}, {});
    group.place(Vec2::Zero(), Vec2::Zero(), {1.0F, 0.0F});
    group.enlist(agents, members);
    // The wall is a quarter of the path; two radii before it.
    EXPECT_TRUE(group.slot_of(0, walls, 0.25F).isApprox(Vec2(0.0F, 0.5F), 1e-5F));
}

/// Walls along the sides of blocked cells of a map, cells of 1 m.
std::vector<Wall> walls_of(const pathfinding::GridMap& map) {
    std::vector<Wall> walls;
    for (int y = -1; y < map.height(); ++y) {
        for (int x = -1; x < map.width(); ++x) {
            const auto open = [&map](int cx, int cy) {
                return cx >= 0 && cy >= 0 &&
                       map.passable(pathfinding::Cell{static_cast<std::uint16_t>(cx),
                                                      static_cast<std::uint16_t>(cy)});
            };
            const auto fx = static_cast<float>(x);
            const auto fy = static_cast<float>(y);
            if (open(x, y) != open(x + 1, y)) {
                walls.push_back({fx + 1, fy, fx + 1, fy + 1});
            }
            if (open(x, y) != open(x, y + 1)) {
                walls.push_back({fx, fy + 1, fx + 1, fy + 1});
            }
        }
    }
    return walls;
}

/// A maze with a dead end that opens towards the goal.
class FormationInAMaze : public testing::Test {
  protected:
    FormationInAMaze() {
        constexpr std::string_view kRows[] = {"........................",
                                              "........................",
                                              "........................",
                                              "......#########.........",
                                              "..............#.........",
                                              "..............#.........",
                                              "..............#.........",
                                              "......#########.........",
                                              "........................",
                                              "........................",
                                              "........................"};
        for (std::uint16_t y = 0; y < 11; ++y) {
            for (std::uint16_t x = 0; x < 24; ++x) {
                map.set_passable({x, y}, kRows[y][x] == '.');
            }
        }
        walls = Walls::make(walls_of(map), 2.0F).value();
        for (std::uint32_t i = 0; i < 5; ++i) {
            // Three in the dead end, two before it.
            agents.add(i,
                       i < 3 ? 10.0F + static_cast<float>(i) : 3.0F,
                       i < 3 ? 5.5F : 2.0F + static_cast<float>(i),
                       0.25F,
                       2.0F);
            members.push_back(i);
        }
    }

    static pathfinding::Cell cell_at(const Vec2& p) {
        return {static_cast<std::uint16_t>(std::clamp(p.x(), 0.0F, 23.0F)),
                static_cast<std::uint16_t>(std::clamp(p.y(), 0.0F, 10.0F))};
    }

    /// The centre walks along x from (4, 1.5) to (19, 1.5), then to (19, 5.5), and stands there.
    void run(const Formation::Route& route) {
        FormationSettings settings;
        settings.straggler_m = 6.0F;
        Formation group(wedge(), settings);
        OrcaAvoidance avoidance({});
        compute::Team alone;
        for (int step = 0; step < 1400; ++step) {
            const float gone = 0.05F * static_cast<float>(step);
            const Vec2 centre(std::min(19.0F, 4.0F + gone), std::clamp(gone - 13.5F, 1.5F, 5.5F));
            const Vec2 velocity(gone < 15.0F ? 1.0F : 0.0F,
                                gone >= 15.0F && gone < 19.0F ? 1.0F : 0.0F);
            group.place(centre, velocity, {1.0F, 0.0F});
            if (step == 0) {
                group.enlist(agents, members);
            }
            group.aim(agents, walls, route);
            avoidance.step(agents, walls, static_cast<std::uint64_t>(step), alone);
        }
        worst = 0.0F;
        for (std::size_t i = 0; i < members.size(); ++i) {
            const Vec2 slot = group.slot_of(i, walls, 0.25F);
            worst = std::max(worst, (slot - Vec2(agents.x[i], agents.z[i])).norm());
            stragglers += group.straggles(i) ? 1 : 0;
        }
    }

    pathfinding::GridMap map{24, 11};
    Walls walls;
    CrowdAgents agents;
    std::vector<std::size_t> members;
    float worst = 0.0F;
    int stragglers = 0;
};

TEST_F(FormationInAMaze, StragglersAreReroutedAndTakenBack) {
    pathfinding::GridPlanner planner(map);
    int asked = 0;
    run([&](std::size_t, const Vec2& from, const Vec2& to) {
        ++asked;
        pathfinding::GridQuery query;
        query.start = cell_at(from);
        query.goal = cell_at(to);
        query.nearest = true;
        planner.plan(query, pathfinding::GridMethod::kAStar);
        const auto& corners = planner.path().corners();
        if (corners.size() < 2) {
            return to;
        }
        return Vec2(static_cast<float>(corners[1].x) + 0.5F,
                    static_cast<float>(corners[1].y) + 0.5F);
    });
    EXPECT_GT(asked, 0);
    EXPECT_EQ(stragglers, 0);
    EXPECT_LT(worst, 0.3F) << "all are in their places, less what others push";
}

/// The subject of the test above: without paths those in the dead end stay there.
TEST_F(FormationInAMaze, WithoutWaysTheyStayInTheDeadEnd) {
    run(kStraightOn);
    EXPECT_GT(stragglers, 0);
    EXPECT_GT(worst, 5.0F);
}

}  // namespace

}  // namespace zoned::ai::steering
