#include "server/ai/steering/flocking.h"
#include "server/ai/steering/steering.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace zoned::ai::test {
namespace {

/// How often the command of an entity changes within `seconds`.
int command_changes(Field& field, std::uint32_t id, float seconds) {
    int changes = 0;
    motion::InputCommand last = field.command(id);
    const Tick end = field.now + static_cast<Tick>(seconds / kDt);
    while (field.now < end) {
        field.step();
        motion::InputCommand next = field.command(id);
        next.tick = last.tick;
        changes += next == last ? 0 : 1;
        last = next;
    }
    return changes;
}

TEST(Idle, StandsExactlyStillAndKeepsItsFacing) {
    Field field;
    field.settings.brains = {single(ActionKind::kIdle)};
    field.add_npc(1, kGuard, 0, Vec3(1.0F, 2.0F, 3.0F));
    field.entities.yaw[0] = 12345;
    field.run(3.0F);
    EXPECT_EQ(field.command(1).move_x, 0);
    EXPECT_EQ(field.command(1).move_z, 0);
    EXPECT_EQ(field.command(1).buttons, 0);
    EXPECT_EQ(field.command(1).yaw, 12345);
    EXPECT_EQ(field.command(1).tick, field.now - 1);
    EXPECT_EQ(field.position(1), Vec3(1.0F, 2.0F, 3.0F));
}

TEST(Chase, ReachesAPlayerThatStandsAndStopsBesideIt) {
    Field field;
    field.settings.brains = {guard_brain()};
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    field.add_player(2, Vec3(8.0F, 0.0F, 6.0F));
    field.run(10.0F);
    EXPECT_EQ(field.state(1), kOnChase);
    EXPECT_EQ(field.entities.stance[0], 2);
    // It stops within kChaseStopM; one tick at 6.4 m/s covers 0.22 m more.
    EXPECT_LT(field.distance(1, 2), kChaseStopM);
    EXPECT_GT(field.distance(1, 2), kChaseStopM - 0.22F);
    EXPECT_EQ(command_changes(field, 1, 2.0F), 0);
}

TEST(Chase, KeepsUpWithAPlayerThatTurns) {
    Field field;
    field.settings.brains = {guard_brain()};
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    const world::Row player = field.add_player(2, Vec3(10.0F, 0.0F, 0.0F));
    // A player on a circle at 5 m/s; the guard sprints at 6.4 m/s.
    for (int tick = 0; tick < 900; ++tick) {
        const float angle = static_cast<float>(tick) * kDt * 0.5F;
        field.entities.position[player] =
            Vec3(10.0F * std::cos(angle), 0.0F, 10.0F * std::sin(angle));
        field.step();
    }
    // Late by at most one decision (0.2 s) of the player's walk, beyond the distance of following.
    EXPECT_LT(field.distance(1, 2), kChaseFollowM + 0.2F * 5.0F);
}

TEST(Chase, TurnsToReturnAndPatrolWhenThePlayerLeaves) {
    Field field;
    field.settings.brains = {guard_brain()};
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    const world::Row player = field.add_player(2, Vec3(10.0F, 0.0F, 0.0F));
    field.run(3.0F);
    ASSERT_EQ(field.state(1), kOnChase);
    field.entities.position[player] = Vec3(500.0F, 0.0F, 0.0F);
    field.run(1.0F);
    EXPECT_EQ(field.state(1), kOnReturn);
    field.run(6.0F);
    EXPECT_EQ(field.state(1), kOnPatrol);
}

TEST(Chase, ForgetsAPlayerThatIsHidden) {
    Field field;
    field.settings.brains = {single(ActionKind::kChase)};
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    const world::Row player = field.add_player(2, Vec3(10.0F, 0.0F, 0.0F));
    field.run(0.5F);
    EXPECT_NE(field.command(1).move_x, 0);
    field.entities.set(player, world::kHidden, true);
    field.step();
    EXPECT_EQ(field.command(1).move_x, 0);
}

TEST(Chase, NoticesGhostPlayersButNotOtherCharacters) {
    Field field;
    field.settings.brains = {guard_brain()};
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    field.add_npc(3, kGuard, 0, Vec3(4.0F, 0.0F, 0.0F));
    field.run(2.0F);
    EXPECT_EQ(field.state(1), kOnPatrol);
    const world::Row ghost = field.add_player(2, Vec3(10.0F, 0.0F, 0.0F));
    field.entities.set(ghost, world::kGhost, true);
    field.run(2.0F);
    EXPECT_EQ(field.state(1), kOnChase);
}

TEST(Chase, PrefersTheOlderOfTwoPlayersEquallyNear) {
    for (const bool swapped : {false, true}) {
        Field field;
        field.settings.brains = {single(ActionKind::kChase)};
        field.add_player(swapped ? 9 : 8, Vec3(5.0F, 0.0F, 0.0F));
        field.add_player(swapped ? 8 : 9, Vec3(-5.0F, 0.0F, 0.0F));
        field.add_npc(1, kGuard, 0, Vec3::Zero());
        field.step();
        EXPECT_EQ(field.agents.find(EntityId(1))->prey, EntityId(8));
    }
}

TEST(Flee, GetsAwayFromThePlayer) {
    Field field;
    field.settings.brains = {single(ActionKind::kFlee)};
    field.add_npc(1, kSheep, 0, Vec3::Zero());
    field.add_player(2, Vec3(3.0F, 0.0F, 0.0F));
    field.run(5.0F);
    EXPECT_NEAR(field.distance(1, 2), 3.0F + 5.0F * 2.0F, 0.2F);
    field.position(2) = field.position(1);  // on the same spot any direction will do
    field.step();
    field.run(1.0F);
    EXPECT_GT(field.distance(1, 2), 1.0F);
}

TEST(Patrol, VisitsTheFourCornersInOrder) {
    Field field;
    field.settings.brains = {single(ActionKind::kPatrol, 8.0F)};
    field.add_npc(1, kGuard, 0, Vec3(100.0F, 0.0F, 50.0F));
    std::vector<int> visited;
    for (int tick = 0; tick < 30 * 40; ++tick) {
        field.step();
        for (int corner = 0; corner < 4; ++corner) {
            const Vec3 at(100.0F + (corner == 1 || corner == 2 ? 8.0F : -8.0F),
                          0.0F,
                          50.0F + (corner >= 2 ? 8.0F : -8.0F));
            if ((field.position(1) - at).norm() < 1.1F * kArriveM &&
                (visited.empty() || visited.back() != corner)) {
                visited.push_back(corner);
            }
        }
    }
    // 16 m a side at 4 m/s: ten corners in 40 s.
    ASSERT_GE(visited.size(), 8u);
    for (std::size_t i = 1; i < visited.size(); ++i) {
        EXPECT_EQ(visited[i], (visited[i - 1] + 1) % 4);
    }
}

TEST(Wander, StaysWithinItsRadiusAndTurnsSeldom) {
    Field field;
    field.settings.brains = {single(ActionKind::kWander, 20.0F)};
    field.add_npc(1, kGuard, 0, Vec3(7.0F, 0.0F, -3.0F));
    float farthest = 0.0F;
    float walked = 0.0F;
    int changes = 0;
    for (int second = 0; second < 120; ++second) {
        const Vec3 before = field.position(1);
        changes += command_changes(field, 1, 1.0F);
        walked += (field.position(1) - before).norm();
        farthest = std::max(farthest, (field.position(1) - Vec3(7.0F, 0.0F, -3.0F)).norm());
    }
    EXPECT_LT(farthest, 20.0F + kArriveM);
    EXPECT_GT(walked, 300.0F);
    // The mean distance of two uniform points of a disc is 0.905 r = 18 m, 4.5 s at 4 m/s. That
    // distance gives about 27 targets in 120 s, each with one turn and seldom a correction.
    EXPECT_LT(changes, 60);
    EXPECT_GT(changes, 10);
}

/// Its disc ends beyond the world: it goes up to the edge and no farther.
TEST(Wander, AndPatrolStayInTheWorld) {
    for (const ActionKind action : {ActionKind::kWander, ActionKind::kPatrol}) {
        Field field;
        field.settings.brains = {single(action, 20.0F)};
        field.world.upper = Vec2(5.0F, 1.0e6F);
        field.add_npc(1, kGuard, 0, Vec3::Zero());
        float farthest = 0.0F;
        for (int i = 0; i < 30 * 120; ++i) {
            field.step();
            farthest = std::max(farthest, field.position(1).x());
        }
        // A walker has arrived a little before its goal or beyond it, by a tick's walk at most.
        EXPECT_NEAR(farthest, 5.0F, 1.5F) << static_cast<int>(action);
    }
}

TEST(Flee, GoesAlongTheEdgeOfTheWorld) {
    const WorldBox world{Vec2(-10.0F, -10.0F), Vec2(10.0F, 10.0F)};
    EXPECT_EQ(world.held({0.0F, 10.5F}, {3.0F, 4.0F}), Vec2(3.0F, 0.0F));
    EXPECT_EQ(world.held({0.0F, 10.5F}, {3.0F, -4.0F}), Vec2(3.0F, -4.0F));
    EXPECT_EQ(world.held({-10.0F, -10.0F}, {-1.0F, -1.0F}), Vec2(0.0F, 0.0F));
    EXPECT_EQ(world.held({0.0F, 0.0F}, {-1.0F, -1.0F}), Vec2(-1.0F, -1.0F));
}

TEST(Wander, FacesWhereItWalks) {
    Field field;
    field.settings.brains = {single(ActionKind::kWander, 20.0F)};
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    for (int tick = 0; tick < 600; ++tick) {
        field.step();
        const motion::InputCommand& c = field.command(1);
        const float angle = static_cast<float>(c.yaw) / 65536.0F * 2.0F * std::numbers::pi_v<float>;
        const Vec2 move = Vec2(c.move_x, c.move_z).normalized();
        // A step of 1/127 turns the direction by up to atan(0.71 / 127) = 0.32 degrees.
        EXPECT_GT(move.dot(Vec2(std::sin(angle), std::cos(angle))), std::cos(0.006F));
        // Two per cent are granted for corrections of quantised commands.
        EXPECT_NEAR(Vec2(c.move_x, c.move_z).norm(), 0.98F * 127.0F, 0.8F);
    }
}

TEST(Wander, PicksAnotherTargetWhenAWallIsInTheWay) {
    Field field;
    field.settings.brains = {single(ActionKind::kWander, 20.0F)};
    field.wall = [](const Vec3& p) {
        return p.x() > 2.0F;
    };  // nearly half of all targets
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    int still = 0;
    int longest = 0;
    for (int tick = 0; tick < 30 * 300; ++tick) {
        const Vec3 before = field.position(1);
        field.step();
        still = field.position(1) == before ? still + 1 : 0;
        longest = std::max(longest, still);
    }
    // Patience is 2 s; several blocked targets may follow each other, but ten on end have a chance
    // of 2^-10 at each of about 100 targets.
    EXPECT_GE(longest, 30);
    EXPECT_LT(longest, 30 * 20);
}

TEST(Return, WalksAroundAWall) {
    Field field;
    field.settings.brains = {single(ActionKind::kReturn)};
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    field.position(1) = Vec3(20.0F, 0.0F, 0.0F);
    field.wall = [](const Vec3& p) {
        return p.x() > 8.0F && p.x() < 10.0F && std::abs(p.z()) < 3.0F;
    };
    field.run(60.0F);
    EXPECT_LT(field.position(1).norm(), kArriveM);
    EXPECT_EQ(field.command(1).move_x, 0);
}

TEST(Flock, KeepsTogetherAndApart) {
    constexpr std::uint32_t kCount = 24;
    constexpr float kRadius = 12.0F;
    Field field;
    field.settings.brains = {single(ActionKind::kFlock, kRadius)};
    core::Rng rng(5);
    for (std::uint32_t id = 1; id <= kCount; ++id) {
        field.add_npc(
            id, kSheep, 0, Vec3(rng.range(-20.0F, 20.0F), 0.0F, rng.range(-20.0F, 20.0F)));
        field.agents.find(EntityId(id))->home = Vec3::Zero();
    }
    field.run(30.0F);
    float worst_nearest = std::numeric_limits<float>::infinity();
    double sum_nearest = 0.0;
    float farthest_from_herd = 0.0F;
    float farthest_from_home = 0.0F;
    int samples = 0;
    for (int second = 0; second < 60; ++second) {
        field.run(1.0F);
        Vec3 centre = Vec3::Zero();
        for (const Vec3& p : field.entities.position) {
            centre += p / static_cast<float>(kCount);
        }
        for (std::uint32_t a = 1; a <= kCount; ++a) {
            float nearest = std::numeric_limits<float>::infinity();
            for (std::uint32_t b = 1; b <= kCount; ++b) {
                if (a != b) {
                    nearest = std::min(nearest, field.distance(a, b));
                }
            }
            worst_nearest = std::min(worst_nearest, nearest);
            sum_nearest += static_cast<double>(nearest);
            ++samples;
            farthest_from_herd = std::max(farthest_from_herd, (field.position(a) - centre).norm());
            farthest_from_home = std::max(farthest_from_home, field.position(a).norm());
        }
    }
    RecordProperty("mean_nearest_m", std::to_string(sum_nearest / samples));
    RecordProperty("worst_nearest_m", std::to_string(worst_nearest));
    RecordProperty("farthest_from_herd_m", std::to_string(farthest_from_herd));
    RecordProperty("farthest_from_home_m", std::to_string(farthest_from_home));
    // Apart: on average more than half the distance at which separation starts (a quarter of the
    // radius); together: within the neighbour radius of the herd's centre and two leashes of home.
    EXPECT_GT(sum_nearest / samples, 0.5 * static_cast<double>(kSeparationShare * kRadius));
    EXPECT_GT(worst_nearest, 0.0F);
    EXPECT_LT(farthest_from_herd, kRadius);
    EXPECT_LT(farthest_from_home, 4.0F * kRadius);
}

TEST(Flock, DoesNotMixWithOtherTypes) {
    Field field;
    field.settings.brains = {single(ActionKind::kFlock, 12.0F)};
    field.add_npc(1, kSheep, 0, Vec3::Zero());
    field.add_npc(2, kGuard, 0, Vec3(1.0F, 0.0F, 0.0F));
    FlockQuery query;
    query.self = 0;
    field.grid.build(field.entities.position, 8.0F);
    EXPECT_EQ(flock_heading(field.entities, field.grid, query), Vec2(0.0F, 0.0F));
}

/// With all else at rest the heading is the sum of the three, each in proportion to its weight.
TEST(Flock, WeighsItsRulesAsABrainSays) {
    FlockSum sum(12.0F);
    sum.add(Vec2(2.0F, 0.0F), Vec2(0.0F, 1.5F), true);
    sum.add(Vec2(0.0F, 8.0F), Vec2(0.5F, 0.0F), false);
    const auto heading = [&](const FlockWeights& weights) {
        FlockPull pull;
        pull.radius_m = 12.0F;
        pull.weights = weights;
        return sum.heading(Vec2::Zero(), pull);
    };
    const Vec2 apart = heading({1.0F, 0.0F, 0.0F});
    const Vec2 along = heading({0.0F, 1.0F, 0.0F});
    const Vec2 together = heading({0.0F, 0.0F, 1.0F});
    // Away from the first alone, a third of the separation distance of 3 m is left.
    EXPECT_NEAR(apart.x(), -1.0F / 3.0F, 1e-3F);
    EXPECT_NEAR(apart.y(), 0.0F, 1e-3F);
    EXPECT_LT((along - Vec2(0.25F, 0.75F)).norm(), 1e-3F);
    EXPECT_LT((together - Vec2(1.0F / 12.0F, 4.0F / 12.0F)).norm(), 1e-3F);
    EXPECT_LT(
        (heading({2.0F, 3.0F, 0.5F}) - (2.0F * apart + 3.0F * along + 0.5F * together)).norm(),
        1e-4F);
}

TEST(Flock, TakesItsWeightsFromTheBrain) {
    const auto spread = [](float cohesion) {
        Field field;
        Brain brain = single(ActionKind::kFlock, 12.0F);
        brain.states.front().flock = {2.0F, 1.0F, cohesion};
        field.settings.brains = {brain};
        for (std::uint32_t i = 0; i < 12; ++i) {
            field.add_npc(i + 1, kSheep, 0, Vec3(static_cast<float>(i), 0.0F, 0.0F));
        }
        field.run(30.0F);
        float sum = 0.0F;
        for (std::uint32_t i = 2; i <= 12; ++i) {
            sum += field.distance(1, i);
        }
        return sum;
    };
    EXPECT_LT(spread(5.0F), 0.8F * spread(0.1F));
}

TEST(Flock, PartsTwoOnTheSameSpot) {
    Field field;
    field.settings.brains = {single(ActionKind::kFlock, 12.0F)};
    field.add_npc(1, kSheep, 0, Vec3::Zero());
    field.add_npc(2, kSheep, 0, Vec3::Zero());
    field.run(1.0F);
    EXPECT_GT(field.distance(1, 2), 0.5F);
}

}  // namespace
}  // namespace zoned::ai::test
