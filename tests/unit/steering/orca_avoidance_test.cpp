#include "server/ai/crowd/orca_avoidance.h"

#include "server/compute/worker_pool.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/steering/crowd_scene.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <utility>

namespace zoned::ai::steering {

namespace {

TEST(OrcaAvoidance, LetsWhoIsAloneGoAsItWants) {
    CrowdAgents agents;
    agents.add(1, 2.0F, 3.0F, 0.25F, 2.0F);
    agents.want_x[0] = 0.8F;
    agents.want_z[0] = -0.6F;
    agents.vx[0] = 0.8F;
    agents.vz[0] = -0.6F;
    OrcaAvoidance avoidance({});
    compute::Team alone;
    for (std::uint64_t tick = 0; tick < 100; ++tick) {
        avoidance.step(agents, Walls(), tick, alone);
    }
    // 100 steps of 0.05 s, each rounded at numbers below 8.
    EXPECT_NEAR(agents.x[0], 2.0F + 4.0F, 100 * 8 * 6e-8F);
    EXPECT_NEAR(agents.z[0], 3.0F - 3.0F, 100 * 8 * 6e-8F);
}

/// Head-on at 1 m/s each, 4 m apart, radii 0.5, with a horizon of 2 s.
TEST(OrcaAvoidance, SharesEvenlyWhatTwoHaveToMakeWay) {
    CrowdAgents agents;
    agents.add(1, 0.0F, 0.0F, 0.5F, 1.0F);
    agents.add(2, 4.0F, 0.1F, 0.5F, 1.0F);
    agents.vx = agents.want_x = {1.0F, -1.0F};
    AvoidanceSettings settings;
    settings.neighbour_m = 5.0F;
    settings.horizon_s = 2.0F;
    OrcaAvoidance avoidance(settings);
    compute::Team alone;
    avoidance.step(agents, Walls(), 0, alone);
    // By symmetry about the middle between them, the velocities of the two differ by half a turn.
    EXPECT_NEAR(agents.vx[0], -agents.vx[1], 1e-6F);
    EXPECT_NEAR(agents.vz[0], -agents.vz[1], 1e-6F);
    // Together out of the obstacle: the relative velocity misses the disc of radii within 2 s.
    const float rx = agents.vx[0] - agents.vx[1];
    const float rz = agents.vz[0] - agents.vz[1];
    float nearest = 1e9F;
    for (int i = 0; i <= 2000; ++i) {
        const float t = 0.001F * static_cast<float>(i);
        nearest = std::min(nearest, std::hypot(4.0F - t * rx, 0.1F - t * rz));
    }
    EXPECT_GT(nearest, 1.0F - 1e-4F);
    EXPECT_LT(nearest, 1.0F + 1e-2F) << "no more than is needed";
}

TEST(OrcaAvoidance, LetsOthersMakeAllTheWayForWhoIsMovedByOthers) {
    CrowdAgents agents;
    agents.add(1, 0.0F, 0.0F, 0.3F, 1.5F);
    agents.add(2, 5.0F, 0.0F, 0.3F, 1.5F);
    agents.want_x[0] = 1.0F;
    agents.yield[1] = 0.0F;
    agents.vx[1] = -1.0F;
    OrcaAvoidance avoidance({});
    compute::Team alone;
    float nearest = 1e9F;
    for (std::uint64_t tick = 0; tick < 120; ++tick) {
        const float before = agents.x[1];
        avoidance.step(agents, Walls(), tick, alone);
        ASSERT_EQ(agents.x[1], before) << "it is moved by others";
        agents.x[1] += 0.05F * agents.vx[1];
        nearest =
            std::min(nearest, std::hypot(agents.x[1] - agents.x[0], agents.z[1] - agents.z[0]));
    }
    EXPECT_GT(nearest, 0.6F * 0.999F);
    EXPECT_GT(agents.x[0], 3.0F);
}

/// The claim of the method: no two agents overlap and none crosses a wall. It holds from any state
/// without overlaps, for any density, desired velocities and sizes.
TEST(OrcaAvoidance, NeverOverlapsNorCrossesWallsWhateverAllWant) {
    core::Rng rng(5);
    for (int round = 0; round < 12; ++round) {
        CrowdScene scene = random_scene(rng, 300, 10.0F + 3.0F * static_cast<float>(round % 4));
        OrcaAvoidance avoidance({});
        compute::Team alone;
        const Walls walls = Walls::make(scene.walls, 3.0F).value();
        for (std::uint64_t tick = 0; tick < 200; ++tick) {
            for (std::size_t i = 0; i < scene.agents.size(); ++i) {
                if ((tick + i) % 20 == 0) {
                    scene.agents.want_x[i] = rng.range(-2.0F, 2.0F);
                    scene.agents.want_z[i] = rng.range(-2.0F, 2.0F);
                }
            }
            const CrowdAgents before = scene.agents;
            avoidance.step(scene.agents, walls, tick, alone);
            // The method lets rounding be up to a thousandth of a radius.
            ASSERT_LT(largest_overlap_share(scene.agents), 2e-3F)
                << "round " << round << " step " << tick;
            ASSERT_LT(deepest_in_wall_share(scene), 2e-3F) << "step " << tick;
            ASSERT_EQ(crossings(before, scene.agents, scene.walls), 0U) << "step " << tick;
        }
    }
}

/// The two checks above, checked: they find deliberate errors.
TEST(CrowdScene, SeesOverlapsAndCrossings) {
    CrowdScene scene;
    scene.agents.add(1, 0.0F, 0.0F, 0.5F, 1.0F);
    scene.agents.add(2, 0.9F, 0.0F, 0.5F, 1.0F);
    scene.walls = {{0.3F, -1.0F, 0.3F, 1.0F}};
    EXPECT_NEAR(largest_overlap_share(scene.agents), 0.2F, 1e-5F);
    EXPECT_NEAR(deepest_in_wall_share(scene), 0.4F, 1e-5F);
    CrowdAgents moved = scene.agents;
    moved.x[0] = 0.5F;
    EXPECT_EQ(crossings(scene.agents, moved, scene.walls), 1U);
}

TEST(OrcaAvoidance, PartsThoseWhoWerePutIntoEachOther) {
    CrowdAgents agents;
    for (std::uint32_t i = 0; i < 30; ++i) {
        agents.add(
            i, 0.05F * static_cast<float>(i % 6), 0.05F * static_cast<float>(i / 6), 0.3F, 1.5F);
    }
    agents.x[1] = agents.x[0];
    agents.z[1] = agents.z[0];
    OrcaAvoidance avoidance({});
    compute::Team alone;
    // From the rim inwards: agents in the middle wait for the others.
    for (std::uint64_t tick = 0; tick < 800; ++tick) {
        avoidance.step(agents, Walls(), tick, alone);
    }
    EXPECT_LT(largest_overlap_share(agents), 2e-3F);
}

/// Two crowds through each other in a corridor of 6 m: all get through, and not much later than
/// they would without each other.
TEST(OrcaAvoidance, ClearsACorridorWithCounterflow) {
    CorridorScene corridor(120, 40.0F, 6.0F, 3);
    const int steps = corridor.run(4000);
    EXPECT_LT(steps, 4000) << corridor.left() << " are still in";
    EXPECT_LT(corridor.worst_overlap, 0.02F);
    // Alone: 40 m and the crowd's own length at 1.3 m/s; three times that is no deadlock.
    EXPECT_LT(static_cast<float>(steps) * 0.05F, 3.0F * 60.0F / 1.3F);
}

/// 100 agents through a door that lets two pass side by side.
TEST(OrcaAvoidance, ClearsADoorwayWithoutDeadlock) {
    for (const float width : {1.2F, 0.8F}) {
        DoorScene door(100, width, 7);
        const int steps = door.run(6000);
        EXPECT_LT(steps, 6000) << door.left() << " are left of a door of " << width;
        EXPECT_LT(door.worst_overlap, 0.02F);
        EXPECT_EQ(door.crossed_walls, 0U);
    }
}

/// A round pillar of far more pieces than are examined.
TEST(OrcaAvoidance, WalksAroundAFinelyCutPillar) {
    CrowdScene scene;
    for (int i = 0; i < 96; ++i) {
        const float from = 6.2831853F * static_cast<float>(i) / 96.0F;
        const float to = 6.2831853F * static_cast<float>(i + 1) / 96.0F;
        scene.walls.push_back({5.0F + 0.3F * std::cos(from),
                               0.3F * std::sin(from),
                               5.0F + 0.3F * std::cos(to),
                               0.3F * std::sin(to)});
    }
    const Walls walls = Walls::make(scene.walls, 3.0F).value();
    for (std::uint32_t i = 0; i < 9; ++i) {
        scene.agents.add(i, -0.7F * static_cast<float>(i), 0.0F, 0.25F, 2.0F);
        scene.agents.want_x[i] = 1.3F;
    }
    OrcaAvoidance avoidance({});
    compute::Team alone;
    for (std::uint64_t tick = 0; tick < 600; ++tick) {
        for (std::size_t i = 0; i < 9; ++i) {
            // To the other side, past the pillar.
            scene.agents.want_z[i] = -0.3F * scene.agents.z[i];
        }
        const CrowdAgents before = scene.agents;
        EXPECT_EQ(avoidance.step(scene.agents, walls, tick, alone).stuck, 0U);
        ASSERT_EQ(crossings(before, scene.agents, scene.walls), 0U);
        ASSERT_LT(deepest_in_wall_share(scene), 2e-3F);
    }
    for (const float x : scene.agents.x) {
        EXPECT_GT(x, 6.0F);
    }
}

TEST(OrcaAvoidance, GivesTheSameBitsForAnyNumberOfThreads) {
    core::Rng rng(9);
    CrowdScene one = random_scene(rng, 2000, 60.0F);
    CrowdScene three = one;
    const Walls walls = Walls::make(one.walls, 3.0F).value();
    OrcaAvoidance on_one({});
    OrcaAvoidance on_three({});
    compute::Team alone;
    compute::WorkerPool pool(3);
    compute::Team team;
    team.join_pool(pool);
    const compute::Team::Shift shift(team);
    for (std::uint64_t tick = 0; tick < 50; ++tick) {
        on_one.step(one.agents, walls, tick, alone);
        on_three.step(three.agents, walls, tick, team);
    }
    const std::size_t bytes = one.agents.size() * sizeof(float);
    EXPECT_EQ(std::memcmp(one.agents.x.data(), three.agents.x.data(), bytes), 0);
    EXPECT_EQ(std::memcmp(one.agents.z.data(), three.agents.z.data(), bytes), 0);
    EXPECT_EQ(std::memcmp(one.agents.vx.data(), three.agents.vx.data(), bytes), 0);
}

TEST(OrcaAvoidance, AllocatesNothingOnceWarm) {
    core::Rng rng(10);
    CrowdScene scene = random_scene(rng, 500, 30.0F);
    const Walls walls = Walls::make(scene.walls, 3.0F).value();
    OrcaAvoidance avoidance({});
    compute::Team alone;
    std::uint64_t tick = 0;
    for (; tick < 20; ++tick) {
        avoidance.step(scene.agents, walls, tick, alone);
    }
    const std::uint64_t before = allocation_count();
    for (; tick < 40; ++tick) {
        avoidance.step(scene.agents, walls, tick, alone);
    }
    EXPECT_EQ(allocation_count() - before, 0U);
}

TEST(Walls, AreRefusedWhereTheyAreNowhere) {
    const Wall walls[] = {{0, 0, 1, 1}, {0, 0, NAN, 1}};
    const auto made = Walls::make(walls, 3.0F);
    ASSERT_FALSE(made);
    EXPECT_THAT(made.error(), testing::StartsWith("wall 1 is not finite"));
}

TEST(Walls, AreVisitedOnceEachWhereverTheBoxLies) {
    core::Rng rng(4);
    std::vector<Wall> walls;
    for (int i = 0; i < 60; ++i) {
        const float x = rng.range(-50.0F, 50.0F);
        const float z = rng.range(-50.0F, 50.0F);
        walls.push_back({x, z, x + rng.range(-40.0F, 40.0F), z + rng.range(-9.0F, 9.0F)});
    }
    const Walls made = Walls::make(walls, 2.5F).value();
    for (int round = 0; round < 300; ++round) {
        const float x = rng.range(-70.0F, 60.0F);
        const float z = rng.range(-70.0F, 60.0F);
        const float x1 = x + rng.range(0.0F, 20.0F);
        const float z1 = z + rng.range(0.0F, 20.0F);
        std::vector<const Wall*> seen;
        made.for_each_near(x, z, x1, z1, [&](const Wall& w) { seen.push_back(&w); });
        for (const Wall& w : made.pieces()) {
            const auto times = std::count(seen.begin(), seen.end(), &w);
            const bool touches = std::min(w.ax, w.bx) <= x1 && std::max(w.ax, w.bx) >= x &&
                                 std::min(w.az, w.bz) <= z1 && std::max(w.az, w.bz) >= z;
            ASSERT_LE(times, 1);
            ASSERT_GE(times, touches ? 1 : 0);
        }
    }
}

}  // namespace

}  // namespace zoned::ai::steering
