// Path providers: rules that hold for paths over cells, polygons and waypoints alike.
#include "server/ai/pathfinding/navmesh/navmesh_paths.h"
#include "server/ai/pathfinding/requests/grid_paths.h"
#include "server/ai/pathfinding/waypoints/waypoint_lattice.h"
#include "server/ai/pathfinding/waypoints/waypoint_paths.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/pathfinding/walkers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

namespace zoned::ai::pathfinding {

namespace {

constexpr GroundRect kMapsYard{-20.0F, -20.0F, 20.0F, 20.0F};
const motion::CharacterLimits kWalks;

motion::Door gate_at(const Vec3& centre, const Vec3& half) {
    motion::Door gate;
    gate.box = static_box(centre, half);
    gate.times.period = 1000;
    gate.times.open = {{100, 200}};
    return gate;
}

/// A wall along z at x = 0 with gates at z = 0 and z = -10, and a gap without one at z = 18.
motion::StaticGeometry yard_with_gates() {
    return {{static_box(Vec3(0.0F, 1.0F, -16.0F), Vec3(0.2F, 2.0F, 4.0F)),
             static_box(Vec3(0.0F, 1.0F, -5.0F), Vec3(0.2F, 2.0F, 3.0F)),
             static_box(Vec3(0.0F, 1.0F, 9.0F), Vec3(0.2F, 2.0F, 7.0F))},
            0.0F,
            motion::kStaticCell_m,
            {},
            {gate_at(Vec3(0.0F, 1.0F, 0.0F), Vec3(0.2F, 2.0F, 2.0F)),
             gate_at(Vec3(0.0F, 1.0F, -10.0F), Vec3(0.2F, 2.0F, 2.0F))}};
}

using Shut = std::vector<std::uint8_t>;

std::unique_ptr<PathProvider> path_map_of(const std::string& kind,
                                          const motion::StaticGeometry& world,
                                          const Shut& shut,
                                          std::uint64_t work) {
    if (kind == "grid") {
        GridPathSettings settings;
        settings.work_per_tick = work;
        return std::make_unique<GridPaths>(world, kWalks, kMapsYard, 0.5F, shut, settings);
    }
    if (kind == "mesh") {
        NavmeshPathsSettings settings;
        settings.queue.work_per_tick = work;
        auto mesh = Navmesh::bake(world, kWalks, kMapsYard);
        EXPECT_TRUE(mesh.ok());
        return std::make_unique<NavmeshPaths>(std::move(mesh).value(), kMapsYard, shut, settings);
    }
    WaypointPathsSettings settings;
    settings.queue.work_per_tick = work;
    auto graph = waypoint_lattice(bake_ground(world, kWalks, kMapsYard, 1.0F));
    EXPECT_TRUE(graph.ok());
    std::vector<WaypointDoor> doors = waypoint_doors(*graph, world, kWalks);
    return std::make_unique<WaypointPaths>(
        std::move(graph).value(), std::move(doors), shut, settings);
}

float length_from(Spot from, std::span<const Spot> corners) {
    float sum = 0.0F;
    for (const Spot& c : corners) {
        sum += std::hypot(c.x - from.x, c.z - from.z);
        from = c;
    }
    return sum;
}

/// Whether any segment passes through a wall or a shut gate by more than a contour may be off: its
/// middle line, at x = 0.
bool crosses(Spot from, std::span<const Spot> corners, const Shut& shut) {
    for (const Spot& to : corners) {
        if ((from.x < 0.0F) != (to.x < 0.0F)) {
            const float z = from.z + (to.z - from.z) * from.x / (from.x - to.x);
            const bool by_gate = (shut[0] == 0 && std::abs(z) < 2.0F) ||
                                 (shut[1] == 0 && std::abs(z + 10.0F) < 2.0F) || z > 16.0F;
            if (!by_gate) {
                return true;
            }
        }
        from = to;
    }
    return false;
}

class PathProviders : public testing::TestWithParam<const char*> {
  protected:
    std::unique_ptr<PathProvider> make(const Shut& shut, std::uint64_t work = 1'000'000) {
        return path_map_of(GetParam(), yard_with_gates(), shut, work);
    }
};

TEST_P(PathProviders, LeadRoundWhatIsShutAndThroughWhatOpensAndLeaveTheRestAlone) {
    const auto map = make({1, 1});
    const Spot from{-10.0F, 0.0F};
    const Spot to{10.0F, 0.0F};
    const PathRequestId across = map->ask({0, from, to});
    const PathRequestId beside = map->ask({1, {-10.0F, 5.0F}, {-3.0F, -14.0F}});
    map->serve();
    ASSERT_EQ(map->answer(across).outcome, PathOutcome::kFound);
    // By the gap: 2 sqrt(10^2 + 17^2) = 39.4 m at least, bar the contours' error; waypoints keep to
    // eight directions, which costs 8 % at most.
    EXPECT_GT(map->answer(across).length_m, 37.5F);
    EXPECT_LT(map->answer(across).length_m, 45.0F);
    EXPECT_FLOAT_EQ(map->answer(across).length_m, length_from(from, map->answer(across).corners));
    EXPECT_FALSE(map->straight(from, kOnGround, to, kOnGround));
    map->turn_doors(Shut{0, 1});
    EXPECT_EQ(std::vector<std::uint32_t>(map->requeued().begin(), map->requeued().end()),
              (std::vector<std::uint32_t>{across.slot}))
        << "the gate may be a short cut for one of both";
    EXPECT_FALSE(map->answer(across).waiting) << "and the old path leads there all the same";
    map->serve();
    EXPECT_LT(map->answer(across).length_m, 22.0F);
    EXPECT_FALSE(crosses(from, map->answer(across).corners, {0, 1}));
    map->turn_doors(Shut{0, 1});
    EXPECT_TRUE(map->requeued().empty()) << "nothing has changed";
    map->turn_doors(Shut{1, 0});
    ASSERT_EQ(map->requeued().size(), 1U);
    EXPECT_TRUE(map->answer(across).waiting);
    EXPECT_EQ(map->counts().broken, 1U);
    map->serve();
    EXPECT_EQ(map->answer(across).outcome, PathOutcome::kFound);
    EXPECT_FALSE(crosses(from, map->answer(across).corners, {1, 0}));
    EXPECT_LT(map->answer(across).length_m, 33.0F) << "by the other gate";
    EXPECT_EQ(map->answer(beside).outcome, PathOutcome::kFound);
}

TEST_P(PathProviders, AnswerEverybodyInTimeWhateverTheLoad) {
    constexpr std::uint32_t kAskers = 3000;
    const auto map = make({0, 1}, 2000);  // work for about three of them
    core::Rng rng(5);
    std::vector<Spot> from;
    std::vector<Spot> to;
    std::vector<PathRequestId> tickets;
    for (std::uint32_t i = 0; i < kAskers; ++i) {
        const bool left = rng.below(2) == 0;
        from.push_back({left ? -5.0F : 5.0F, rng.range(-15.0F, 15.0F)});
        to.push_back({rng.range(2.0F, 15.0F), rng.range(-15.0F, 15.0F)});
        tickets.push_back(map->ask({i, from[i], to[i]}));
    }
    for (int tick = 0; tick < 20; ++tick) {
        map->serve();
    }
    EXPECT_LE(map->counts().longest_wait_ticks, 20U);
    EXPECT_GT(map->counts().by_regions, kAskers / 10) << "most are served late";
    double sum = 0.0;
    double straight = 0.0;
    for (std::uint32_t i = 0; i < kAskers; ++i) {
        const PathResult a = map->answer(tickets[i]);
        ASSERT_FALSE(a.waiting);
        ASSERT_EQ(a.outcome, PathOutcome::kFound);
        ASSERT_NEAR(a.corners.back().x, to[i].x, 1e-4F);
        ASSERT_FALSE(crosses(from[i], a.corners, {0, 1}));
        sum += a.length_m;
        straight += std::hypot(to[i].x - from[i].x, to[i].z - from[i].z);
    }
    // Paths are longer than straight lines by the walls on them and by the excess of cheap ones.
    EXPECT_LT(sum, 1.5 * straight);
}

TEST_P(PathProviders, SendWhoWaitsSomewhereSensibleFromTheFirstTick) {
    const auto map = make({0, 1});
    Spot at{-10.0F, -6.0F};
    const Spot to{10.0F, 6.0F};
    const PathRequestId ticket = map->ask({0, at, to});
    // No request is served: it walks by first segments alone, 0.1 m at a time.
    int steps = 0;
    while (std::hypot(at.x - to.x, at.z - to.z) > 0.5F && steps < 600) {
        const Spot head = map->heading(ticket, at, 0.3F);
        const float path = std::hypot(head.x - at.x, head.z - at.z);
        ASSERT_GT(path, 0.01F) << "stands at " << at.x << " " << at.z;
        const Spot next{at.x + 0.1F * (head.x - at.x) / path, at.z + 0.1F * (head.z - at.z) / path};
        ASSERT_FALSE(crosses(at, std::span(&next, 1), {0, 1}));
        at = next;
        ++steps;
    }
    // The straight line through the gate is 23.3 m; regions, polygons and waypoints cost some more.
    EXPECT_LT(steps, 330);
}

TEST_P(PathProviders, SayHowNearOneGetsToWhereNoWayLeads) {
    // The right half is shut off.
    motion::StaticGeometry half({static_box(Vec3(0.0F, 1.0F, 0.0F), Vec3(0.2F, 2.0F, 20.5F))},
                                0.0F);
    const auto map = path_map_of(GetParam(), half, {}, 1'000'000);
    const PathRequestId t = map->ask({0, {-10.0F, 0.0F}, {10.0F, 4.0F}});
    const PathRequestId nan = map->ask({1, {-10.0F, 0.0F}, {std::nanf(""), 4.0F}});
    map->serve();
    const PathResult a = map->answer(t);
    EXPECT_EQ(a.outcome, PathOutcome::kPartial);
    // As near to the wall as a body comes, rounded to cells, or to the lattice.
    EXPECT_GT(a.corners.back().x, -2.0F);
    EXPECT_LT(a.corners.back().x, -0.3F);
    EXPECT_NEAR(a.corners.back().z, 4.0F, 1.0F);
    EXPECT_EQ(map->answer(nan).outcome, PathOutcome::kOffMap);
}

TEST_P(PathProviders, AllocateNothingOnceWarm) {
    const auto map = make({1, 1});
    core::Rng rng(9, 1);
    std::vector<PathRequestId> tickets(80);
    const auto live = [&](int ticks, bool turn) {
        for (int tick = 0; tick < ticks; ++tick) {
            if (turn) {
                const auto state = rng.below(4);
                map->turn_doors(Shut{static_cast<std::uint8_t>(state & 1U),
                                     static_cast<std::uint8_t>(state / 2)});
            }
            for (std::uint32_t i = 0; i < tickets.size(); ++i) {
                if (rng.below(8) == 0) {
                    if (tickets[i].slot != ~0U) {
                        map->release(tickets[i]);
                    }
                    tickets[i] = map->ask({i,
                                           {rng.range(-19.0F, 19.0F), rng.range(-19.0F, 19.0F)},
                                           {rng.range(-19.0F, 19.0F), rng.range(-19.0F, 19.0F)}});
                }
            }
            map->serve();
        }
    };
    live(3000, true);
    live(300, false);
    const std::uint64_t before = allocation_count();
    live(500, false);
    EXPECT_EQ(allocation_count(), before);
}

TEST_P(PathProviders, AnswerAlikeWhateverWasAskedBefore) {
    // The same requests on a map that has lived and on a fresh one.
    const auto old = make({1, 0});
    core::Rng rng(3);
    for (int i = 0; i < 200; ++i) {
        const PathRequestId t = old->ask({0,
                                          {rng.range(-19.0F, 19.0F), rng.range(-19.0F, 19.0F)},
                                          {rng.range(-19.0F, 19.0F), rng.range(-19.0F, 19.0F)}});
        old->turn_doors(
            Shut{static_cast<std::uint8_t>(i % 2), static_cast<std::uint8_t>(i / 2 % 2)});
        old->serve();
        old->release(t);
    }
    old->turn_doors(Shut{0, 1});
    for (int i = 0; i < 40; ++i) {
        old->serve();
    }
    const auto fresh = make({0, 1});
    for (int i = 0; i < 300; ++i) {
        const PathRequest ask{0,
                              {rng.range(-19.0F, 19.0F), rng.range(-19.0F, 19.0F)},
                              {rng.range(-19.0F, 19.0F), rng.range(-19.0F, 19.0F)}};
        const PathRequestId a = old->ask(ask);
        const PathRequestId b = fresh->ask(ask);
        old->serve();
        fresh->serve();
        ASSERT_EQ(old->answer(a).outcome, fresh->answer(b).outcome) << i;
        ASSERT_NEAR(old->answer(a).length_m, fresh->answer(b).length_m, 1e-3F) << i;
        old->release(a);
        fresh->release(b);
    }
}

INSTANTIATE_TEST_SUITE_P(All,
                         PathProviders,
                         testing::Values("grid", "mesh", "graph"),
                         [](const auto& kind) { return std::string(kind.param); });

}  // namespace

}  // namespace zoned::ai::pathfinding
