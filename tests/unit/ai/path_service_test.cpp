// PathService: agents request paths, doors turn, and every agent has a result in time.
#include "server/ai/pathfinding/path_service.h"

#include "server/ai/pathfinding/grid/line_of_sight.h"
#include "tests/unit/allocation_count.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace zoned::ai::ways_test {
namespace {

using pathfinding::PathOutcome;
using pathfinding::Spot;

constexpr pathfinding::GroundRect kTown{-20.0F, -20.0F, 20.0F, 20.0F};

motion::StaticBox wall(const Vec3& centre, const Vec3& half) {
    motion::StaticBox box;
    box.centre = centre;
    box.half_extents = half;
    return box;
}

/// A wall along z at x = 0 with a gate at z = 0, open in ticks 100 to 200 of 1000, and a gap
/// without a door at z = 18.
motion::StaticGeometry town() {
    motion::Door gate;
    gate.box = wall(Vec3(0.0F, 1.0F, 0.0F), Vec3(0.2F, 2.0F, 1.5F));
    gate.times.period = 1000;
    gate.times.open = {{100, 200}};
    return {{wall(Vec3(0.0F, 1.0F, -10.75F), Vec3(0.2F, 2.0F, 9.25F)),
             wall(Vec3(0.0F, 1.0F, 9.0F), Vec3(0.2F, 2.0F, 7.5F))},
            0.0F,
            motion::kStaticCell_m,
            {},
            {gate}};
}

world::TypeTable kinds() {
    world::TypeTable types(4);
    types[0].kind = world::EntityKind::kCharacter;  // of players: no agent
    types[1].kind = world::EntityKind::kCharacter;
    types[1].brain = 1;
    types[2] = types[1];
    types[2].character.speed = 1.0F;  // slower, but of the same size
    types[3] = types[1];
    types[3].character.radius = 0.8F;
    return types;
}

PathService paths_at(Tick now, std::uint64_t work = 1'000'000) {
    return {{0.5F, work}, town(), kTown, kinds(), now};
}

float length(Spot from, std::span<const Spot> corners) {
    float sum = 0.0F;
    for (const Spot& c : corners) {
        sum += std::hypot(c.x - from.x, c.z - from.z);
        from = c;
    }
    return sum;
}

TEST(PathService, HaveAMapForEachSizeOfCharactersWithAgentsAlone) {
    const PathService paths = paths_at(0);
    EXPECT_EQ(paths.sizes(), 2U);
    EXPECT_FALSE(paths.plans_for(0));
    EXPECT_TRUE(paths.plans_for(1));
    EXPECT_TRUE(paths.plans_for(3));
    EXPECT_FALSE(paths.plans_for(4));
    EXPECT_GT(paths.bytes(), 0U);
    const PathService none({}, town(), kTown, kinds(), 0);
    EXPECT_TRUE(none.empty());
    EXPECT_FALSE(none.plans_for(1));
    EXPECT_EQ(none.bytes(), 0U);
}

TEST(PathService, AreAnsweredInTheTickInWhichTheyAreAskedFor) {
    PathService paths = paths_at(150);
    const Spot from{-10.0F, 0.0F};
    const Spot to{10.0F, 0.0F};
    paths.ask(7, EntityId(70), 1, from, to);
    paths.ask(3, EntityId(30), 3, from, to);
    paths.ask(5, EntityId(50), 2, from, {10.0F, 100.0F});
    paths.serve();
    ASSERT_EQ(std::vector<Slot>(paths.answered().begin(), paths.answered().end()),
              (std::vector<Slot>{3, 5, 7}));
    for (const Slot agent : {7U, 3U}) {
        const pathfinding::PathResult a = paths.answer(agent);
        ASSERT_FALSE(a.waiting);
        EXPECT_EQ(a.outcome, PathOutcome::kFound);
        ASSERT_EQ(a.corners.size(), 1U) << "straight through the open gate";
        EXPECT_EQ(a.corners.back(), to);
        EXPECT_FLOAT_EQ(a.length_m, 20.0F);
    }
    EXPECT_EQ(paths.answer(5).outcome, PathOutcome::kPartial) << "beyond the zone";
    EXPECT_TRUE(paths.has(7, EntityId(70)));
    EXPECT_FALSE(paths.has(7, EntityId(71)));
    paths.release(7);
    EXPECT_FALSE(paths.has(7, EntityId(70)));
    paths.release(7);
    paths.serve();
    EXPECT_TRUE(paths.answered().empty());
}

TEST(PathService, GoRoundAGateThatIsShutAndThroughItAgainOnceItIsOpen) {
    PathService paths = paths_at(90);
    const Spot from{-10.0F, 0.0F};
    const Spot to{10.0F, 0.0F};
    paths.ask(0, EntityId(1), 1, from, to);
    paths.serve();
    ASSERT_EQ(paths.answer(0).outcome, PathOutcome::kFound);
    // By the gap at z = 17: the shortest path there and back is 2 sqrt(10^2 + 17^2) = 39.4 m.
    EXPECT_GT(paths.answer(0).length_m, 38.0F);
    EXPECT_LT(paths.answer(0).length_m, 44.0F);
    EXPECT_FLOAT_EQ(paths.answer(0).length_m, length(from, paths.answer(0).corners));
    EXPECT_FALSE(paths.straight(1, from, to));
    for (Tick tick = 91; tick < 100; ++tick) {
        paths.follow_doors(tick);
        paths.serve();
        EXPECT_TRUE(paths.answered().empty());
    }
    paths.follow_doors(100);
    EXPECT_EQ(paths.requeued().size(), 1U) << "the gate may be a short cut";
    EXPECT_FALSE(paths.answer(0).waiting) << "and the old path leads there all the same";
    EXPECT_TRUE(paths.straight(1, from, to));
    paths.serve();
    ASSERT_EQ(paths.answered().size(), 1U);
    EXPECT_FLOAT_EQ(paths.answer(0).length_m, 20.0F);
    paths.follow_doors(200);
    ASSERT_EQ(paths.requeued().size(), 1U);
    EXPECT_TRUE(paths.answer(0).waiting);
    paths.serve();
    EXPECT_GT(paths.answer(0).length_m, 38.0F);
}

TEST(PathService, LeadOutOfTheZoneToAPlaceBeyondItWhereItCanBeLeft) {
    // A wall along the east side of the town, with a gap from z = 10 to z = 12.
    motion::StaticGeometry walls({wall(Vec3(19.5F, 1.0F, -5.0F), Vec3(0.5F, 2.0F, 15.0F)),
                                  wall(Vec3(19.5F, 1.0F, 16.0F), Vec3(0.5F, 2.0F, 4.0F))},
                                 0.0F);
    PathService paths({0.5F, 1'000'000}, walls, kTown, kinds(), 0);
    paths.ask(0, EntityId(1), 1, {0.0F, 0.0F}, {60.0F, 0.0F});
    paths.ask(1, EntityId(2), 1, {0.0F, 0.0F}, {60.0F, 60.0F});
    paths.ask(2, EntityId(3), 1, {0.0F, 0.0F}, {0.0F, -60.0F});
    paths.ask(3, EntityId(4), 1, {0.0F, 0.0F}, {std::nanf(""), 0.0F});
    paths.serve();
    EXPECT_EQ(paths.answer(0).outcome, PathOutcome::kPartial);
    const Spot east = paths.answer(0).corners.back();
    EXPECT_FLOAT_EQ(east.x, 19.75F);
    EXPECT_GT(east.z, 10.0F);
    EXPECT_LT(east.z, 12.0F);
    // To the south-east by the south side, which is free: straight ahead.
    const Spot corner = paths.answer(1).corners.back();
    EXPECT_TRUE(corner.z > 19.0F || corner.x > 19.0F);
    EXPECT_EQ(paths.answer(2).corners.back(), (Spot{-0.25F, -19.75F}));
    EXPECT_EQ(paths.answer(3).outcome, PathOutcome::kOffMap);
}

TEST(PathService, ForgetWhoseSlotIsAnothers) {
    PathService paths = paths_at(150, 1);
    for (Slot agent = 0; agent < 50; ++agent) {
        paths.ask(agent, EntityId(agent + 1), 1, {-10.0F, 5.0F}, {10.0F, 5.0F});
    }
    for (Slot agent = 0; agent < 50; agent += 2) {
        paths.ask(agent, EntityId(agent + 1000), 3, {-10.0F, 5.0F}, {10.0F, -5.0F});
    }
    for (int tick = 0; tick < 40; ++tick) {
        paths.serve();
        for (const Slot agent : paths.answered()) {
            EXPECT_FALSE(paths.answer(agent).waiting);
        }
    }
    for (Slot agent = 0; agent < 50; ++agent) {
        ASSERT_FALSE(paths.answer(agent).waiting);
        EXPECT_EQ(paths.answer(agent).corners.back(), (Spot{10.0F, agent % 2 == 0 ? -5.0F : 5.0F}));
    }
}

TEST(PathService, AllocateNothingOnceAllHaveAsked) {
    PathService paths = paths_at(0);
    core::Rng rng(9, 1);
    const auto somewhere = [&rng] {
        return Spot{rng.range(-19.0F, 19.0F), rng.range(-19.0F, 19.0F)};
    };
    const auto live = [&](Tick from, Tick to) {
        for (Tick tick = from; tick < to; ++tick) {
            paths.follow_doors(tick);
            for (Slot agent = 0; agent < 100; ++agent) {
                if (rng.below(8) == 0) {
                    paths.ask(agent,
                              EntityId(agent + 1),
                              agent % 2 == 0 ? 1 : 3,
                              somewhere(),
                              somewhere());
                }
            }
            paths.serve();
        }
    };
    live(0, 3300);
    const std::uint64_t before = allocation_count();
    live(3300, 4000);  // no door turns: the index is as it was
    EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace zoned::ai::ways_test
