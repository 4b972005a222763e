#include "server/ai/pathfinding/flow_fields/flock_flow_field.h"

#include "server/compute/stages/flock_stage.h"

#include <gmock/gmock.h>

#include <cmath>

namespace zoned::ai::pathfinding {

namespace {

Vec2 direction_in(const FlockFlowField& f, int column, int row) {
    const auto at = 2 * static_cast<std::size_t>(row * f.columns + column);
    return {f.directions[at], f.directions[at + 1]};
}

TEST(FlockFlowField, LeadsAlongAPathAndBackToIt) {
    // Along x at z = 5.5, from 0.5 to 20.5, cells of 1 m, so that middles of cells lie on it.
    const Vec2 path[] = {{0.5F, 5.5F}, {20.5F, 5.5F}};
    const FlockFlowField f = along_path(path, {0.0F, 0.0F, 1.0F, 30, 12, {}}, 4.0F);
    ASSERT_EQ(f.directions.size(), 2U * 30 * 12);
    EXPECT_TRUE(direction_in(f, 10, 5).isApprox(Vec2(1.0F, 0.0F), 1e-6F)) << "on it";
    // 4 m beside it: as much towards it as along it.
    EXPECT_TRUE(direction_in(f, 10, 1).isApprox(Vec2(std::sqrt(0.5F), std::sqrt(0.5F)), 1e-6F));
    EXPECT_TRUE(direction_in(f, 10, 9).isApprox(Vec2(std::sqrt(0.5F), -std::sqrt(0.5F)), 1e-6F));
    EXPECT_TRUE(direction_in(f, 25, 5).isApprox(Vec2(-1.0F, 0.0F), 1e-6F)) << "beyond the end";
}

TEST(FlockFlowField, LeadsToAGoalOfAMap) {
    GridMap map(3, 2);
    for (std::uint16_t x = 0; x < 3; ++x) {
        map.set_passable({x, 0}, true);
    }
    map.set_passable({0, 1}, true);
    FlowField field;
    field.build(map, {2, 0});
    const FlockFlowField f = to_goal(map, field, 0.0F, 0.0F, 2.0F);
    EXPECT_EQ(direction_in(f, 0, 0), Vec2(1.0F, 0.0F));
    EXPECT_EQ(direction_in(f, 1, 0), Vec2(1.0F, 0.0F));
    EXPECT_EQ(direction_in(f, 2, 0), Vec2(0.0F, 0.0F)) << "the goal";
    EXPECT_EQ(direction_in(f, 0, 1), Vec2(0.0F, -1.0F));
    EXPECT_EQ(direction_in(f, 2, 1), Vec2(0.0F, 0.0F)) << "blocked";
}

/// A flock of 200 that starts beside a path follows it to its end.
TEST(FlockFlowField, SteersAFlockToTheEndOfAPath) {
    kernels::FlockRules rules{};
    rules.h = 1.0F / 60.0F;
    rules.radius2 = 9.0F;
    rules.separation2 = 1.0F;
    rules.separation = 4.0F;
    rules.alignment = 0.5F;
    rules.cohesion = 0.3F;
    rules.most_acceleration = 12.0F;
    rules.least_speed = 1.0F;
    rules.most_speed = 6.0F;
    rules.high_x = rules.high_z = 100.0F;
    rules.turn_back = 8.0F;
    const Vec2 path[] = {{10.0F, 10.0F}, {90.0F, 10.0F}, {90.0F, 90.0F}};
    const FlockFlowField f = along_path(path, {0.0F, 0.0F, 2.0F, 50, 50, {}}, 6.0F);
    f.steer(rules, 2.0F);
    compute::ParticleColumns agents;
    agents.reserve(200);
    for (std::size_t i = 0; i < 200; ++i) {
        agents.column(0)[i] = 10.0F + static_cast<float>(i % 14);
        agents.column(1)[i] = 0.0F;
        agents.column(2)[i] = 20.0F + static_cast<float>(i / 14);
        agents.column(3)[i] = -1.0F;
        agents.column(4)[i] = agents.column(5)[i] = 0.0F;
    }
    compute::FlockStage stage;
    compute::Team alone;
    double at_bend = 1e9;
    // 160 m of path at up to 6 m/s: 27 s at best.
    for (int step = 0; step < 60 * 45; ++step) {
        stage.step(agents, 200, rules, alone, f.directions);
        double x = 0.0;
        double z = 0.0;
        for (std::size_t i = 0; i < 200; ++i) {
            x += static_cast<double>(agents.column(0)[i]) / 200.0;
            z += static_cast<double>(agents.column(2)[i]) / 200.0;
        }
        at_bend = std::min(at_bend, std::hypot(x - 90.0, z - 10.0));
        if (step == 60 * 45 - 1) {
            EXPECT_LT(std::hypot(x - 90.0, z - 90.0), 15.0);
        }
    }
    EXPECT_LT(at_bend, 15.0) << "it cuts across";
}

}  // namespace

}  // namespace zoned::ai::pathfinding
