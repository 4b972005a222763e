// Agents that walk by navmeshes and waypoints: over a bridge and under it, and where doors turn.
#include "server/ai/steering/path_following.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

namespace zoned::ai {
namespace {

using namespace test;

Brain walker_home() {
    Brain brain = single(ActionKind::kReturn);
    brain.states[0].speed_factor = 0.8F;
    return brain;
}

/// A deck along x, its top at 3 m, with a ramp of 23 degrees at each end, over a street along z.
std::vector<motion::StaticBox> bridge() {
    const float slope = std::atan(3.0F / 7.0F);
    const float half = 0.5F * std::hypot(3.0F, 7.0F);
    const Vec3 below(std::sin(slope) * 0.1F, -std::cos(slope) * 0.1F, 0.0F);
    const auto ramp = [&](float side) {
        return slab(Vec3(side * 7.5F - side * below.x(), 1.5F + below.y(), 0.0F),
                    Vec3(half + 0.1F, 0.1F, 2.0F),
                    -side * slope);
    };
    return {slab(Vec3(0.0F, 2.9F, 0.0F), Vec3(4.0F, 0.1F, 2.0F)), ramp(-1.0F), ramp(1.0F)};
}

class Place {
  public:
    Place(const motion::StaticGeometry& statics, const PathfindingSettings& paths, bool simulated) {
        field.statics = statics;
        field.settings.brains = {walker_home()};
        field.settings.viewer_range_m = simulated ? std::numeric_limits<float>::infinity() : 50.0F;
        field.solid = true;
        for (world::EntityType& type : field.types) {
            type.brain = 1;
            type.character.acceleration = 20.0F;
        }
        field.paths = PathService(paths, field.statics, {-25, -25, 25, 25}, field.types, 0);
        compile(field.settings, kDt);
    }

    void add(std::uint32_t id, const Vec3& at, const Vec3& home) {
        field.add_npc(id, kGuard, 0, at);
        field.agents.find(EntityId(id))->home = home;
        field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
    }

    Field field;
};

class AgentsOnABridge : public testing::TestWithParam<bool> {};

/// Feet are on the bridge at 3.9 m (the middle of the body is 0.9 m above them), in the street at
/// 0.9 m.
TEST_P(AgentsOnABridge, WalkOverItAndUnderItEachToItsHome) {
    const float up = 3.9F;
    const float down = 0.9F;
    Place place({bridge(), 0.0F}, {0.25F, 1'000'000, PathMapKind::kNavmesh}, GetParam());
    place.add(1, Vec3(-15.0F, down, 5.0F), Vec3(0.0F, up, 0.5F));      // up from the street
    place.add(2, Vec3(-15.0F, down, -5.0F), Vec3(0.5F, down, 0.0F));   // under the deck
    place.add(3, Vec3(0.0F, down, -12.0F), Vec3(-0.5F, down, 12.0F));  // along the street
    place.add(4, Vec3(0.0F, up, -0.5F), Vec3(1.0F, down, 1.0F));       // down from above that
    place.add(5, Vec3(-14.0F, down, 0.0F), Vec3(14.0F, down, 0.5F));   // over the bridge
    for (Tick tick = 0; tick < 30 * 30; ++tick) {
        place.field.step();
    }
    for (const std::uint32_t id : {1U, 2U, 3U, 4U, 5U}) {
        const Agent& agent = *place.field.agents.find(EntityId(id));
        const Vec3& at = place.field.position(id);
        const Vec2 off(at.x() - agent.home.x(), at.z() - agent.home.z());
        EXPECT_LT(off.norm(), kArriveM + 0.1F) << id;
        // A body stands on a deck, apart from its sinking in and its rounding of the edge.
        EXPECT_NEAR(at.y(), agent.home.y(), 0.1F) << id;
    }
}

INSTANTIATE_TEST_SUITE_P(Seen, AgentsOnABridge, testing::Bool(), [](const auto& kind) {
    return std::string(kind.param ? "Simulated" : "Unseen");
});

/// A wall along z at x = 0 from z = -25 to 16.5, with a gate of 3 m at z = 0.
motion::StaticGeometry walled(Tick opens, Tick shuts) {
    motion::Door gate;
    gate.box = slab(Vec3(0.0F, 1.0F, 0.0F), Vec3(0.2F, 2.0F, 1.5F));
    gate.times.period = 10000;
    gate.times.open = {{opens, shuts}};
    return {{slab(Vec3(0.0F, 1.0F, -13.25F), Vec3(0.2F, 2.0F, 11.75F)),
             slab(Vec3(0.0F, 1.0F, 9.0F), Vec3(0.2F, 2.0F, 7.5F))},
            0.0F,
            motion::kStaticCell_m,
            {},
            {gate}};
}

/// An agent that leaves a zone has to leave the whole area, or no other zone takes it over.
TEST(PathsOnANavmesh, LeadOutOfTheWholeArea) {
    world::TypeTable types(2);
    for (std::size_t t = 0; t < types.size(); ++t) {
        types[t].kind = world::EntityKind::kCharacter;
        types[t].brain = 1;
    }
    types[1].character.radius = 1.1F;
    PathService paths({0.25F, 1'000'000, PathMapKind::kNavmesh},
                      motion::StaticGeometry(bridge(), 0.0F),
                      {-25, -25, 25, 25},
                      types,
                      0);
    const std::array<pathfinding::Spot, 4> goals{{{90, 3}, {-90, 3}, {3, 90}, {3, -90}}};
    for (Slot agent = 0; agent < 8; ++agent) {
        paths.ask(agent, EntityId(agent + 1), agent / 4, {3.0F, 8.0F}, goals[agent % 4], {0.0F});
    }
    paths.serve();
    for (Slot agent = 0; agent < 8; ++agent) {
        const pathfinding::PathResult a = paths.answer(agent);
        ASSERT_EQ(a.outcome, pathfinding::PathOutcome::kPartial);
        const pathfinding::Spot end = a.corners.back();
        EXPECT_GT(std::max(std::abs(end.x), std::abs(end.z)), 25.0F) << agent;
    }
}

class AgentsAtADoor : public testing::TestWithParam<PathMapKind> {};

TEST_P(AgentsAtADoor, TurnRoundWhereItShutsBeforeThemAndGoThroughWhereItOpens) {
    const PathfindingSettings paths{
        GetParam() == PathMapKind::kWaypointGraph ? 1.0F : 0.25F, 1'000'000, GetParam()};
    // 10 m to the gate at 3.2 m/s: it shuts 2 s from now, and opens while they are on their path.
    for (const bool shuts : {true, false}) {
        Place place(walled(shuts ? 0 : 100, shuts ? 60 : 9000), paths, true);
        for (std::uint32_t id = 1; id <= 6; ++id) {
            const float z = static_cast<float>(id) - 3.5F;
            place.add(id, Vec3(-10.0F, 0.9F, z), Vec3(10.0F, 0.9F, z));
        }
        std::array<float, 7> farthest{};
        for (Tick tick = 0; tick < 30 * 24; ++tick) {
            place.field.step();
            const bool shut = place.field.statics.shut_at(0, place.field.now - 1);
            for (std::uint32_t id = 1; id <= 6; ++id) {
                const Vec3& at = place.field.position(id);
                const bool in_wall =
                    std::abs(at.x()) < 0.2F && at.z() < 16.5F && (std::abs(at.z()) > 1.5F || shut);
                ASSERT_FALSE(in_wall) << id << " in tick " << tick;
                farthest[id] = std::max(farthest[id], at.z());
            }
        }
        for (std::uint32_t id = 1; id <= 6; ++id) {
            const Vec3& at = place.field.position(id);
            const Agent& agent = *place.field.agents.find(EntityId(id));
            EXPECT_LT((at - agent.home).norm(), kArriveM + 0.2F) << id;
            EXPECT_EQ(farthest[id] > 16.0F, shuts) << id << ": by the gap, or by the gate";
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Maps,
                         AgentsAtADoor,
                         testing::Values(PathMapKind::kGrid,
                                         PathMapKind::kNavmesh,
                                         PathMapKind::kWaypointGraph),
                         [](const auto& kind) {
                             return std::string(kind.param == PathMapKind::kGrid      ? "Grid"
                                                : kind.param == PathMapKind::kNavmesh ? "Mesh"
                                                                                      : "Graph");
                         });

}  // namespace
}  // namespace zoned::ai
