// Walks over the static world without a map: what holds a walker up, seen and unseen.
#include "server/ai/steering/terrain_walk.h"

#include "tests/unit/ai/field.h"
#include "shared/motion/capsule_sweep.h"

#include <gtest/gtest.h>

#include <numbers>

namespace zoned::ai {
namespace {

using namespace test;

/// How far one gets from the origin in direction x (turned to z by `angle`), of 40 m.
float gets(const motion::StaticGeometry& statics, float angle = 0.0F, Tick now = 0) {
    const motion::CharacterLimits limits;
    const Vec3 from(0.0F, limits.radius + limits.half_segment, 0.0F);
    const Vec2 direction(std::cos(angle), std::sin(angle));
    return look_ahead(from, direction, 40.0F, limits, statics, now).length;
}

motion::StaticGeometry world_of(std::vector<motion::StaticBox> boxes,
                                std::vector<motion::Door> doors = {}) {
    return {std::move(boxes), 0.0F, motion::kStaticCell_m, {}, std::move(doors)};
}

const float kWalkerRadius = motion::CharacterLimits().radius;

TEST(WalkAhead, IsAllOfItWhereNothingStands) {
    EXPECT_EQ(gets(world_of({})), 40.0F);
    EXPECT_EQ(gets(world_of({slab({20.0F, 1.0F, 3.0F}, {1.0F, 1.0F, 1.0F})})), 40.0F) << "beside";
}

TEST(WalkAhead, EndsAtAWall) {
    for (const float at : {1.0F, 2.9F, 17.3F, 39.0F}) {
        const float free = gets(world_of({slab({at, 1.0F, 0.0F}, {0.2F, 1.0F, 5.0F})}));
        EXPECT_NEAR(free, at - 0.2F - kWalkerRadius, 2.0F * motion::kSkin) << at;
    }
}

/// A character that walks into a wall at an angle slides along it. The straight line may lead as
/// far into it as one is led aside meanwhile: 0.1 m, and a piece of 0.2 m.
TEST(WalkAhead, EndsAtAWallThatLeadsAside) {
    const motion::StaticGeometry statics =
        world_of({slab({20.0F, 1.0F, 4.0F}, {60.0F, 1.0F, 0.2F})});
    for (const float degrees : {10.0F, 30.0F, 60.0F, 80.0F}) {
        const float angle = degrees * std::numbers::pi_v<float> / 180.0F;
        const float depth = gets(statics, angle) * std::sin(angle) - (3.8F - kWalkerRadius);
        EXPECT_GT(depth, -0.05F) << degrees;
        EXPECT_LT(depth, 0.3F) << degrees;
    }
}

TEST(WalkAhead, IsAllOfItOverLedgesRampsAndDrops) {
    const motion::CharacterLimits limits;
    const float ledge = 0.9F * limits.step_up;
    EXPECT_EQ(gets(world_of({slab({10.0F, 0.5F * ledge, 0.0F}, {3.0F, 0.5F * ledge, 5.0F})})),
              40.0F);
    // A ramp of 25 degrees and 2.1 m, a platform behind it, and its far edge.
    const motion::StaticBox ramp =
        slab({6.0F, 0.85F, 0.0F}, {2.5F, 0.2F, 2.0F}, 25.0F * std::numbers::pi_v<float> / 180.0F);
    const motion::StaticBox platform = slab({13.0F, 0.95F, 0.0F}, {5.0F, 0.95F, 2.0F});
    EXPECT_EQ(gets(world_of({ramp, platform})), 40.0F);
    EXPECT_LT(gets(world_of({platform})), 8.0F) << "without its ramp";
}

TEST(WalkAhead, EndsAtADoorThatIsShut) {
    motion::Door door;
    door.box = slab({10.0F, 1.0F, 0.0F}, {0.2F, 1.0F, 5.0F});
    door.times.period = 1000;
    door.times.open = {{100, 200}};
    const motion::StaticGeometry statics = world_of({}, {door});
    EXPECT_LT(gets(statics, 0.0F, 50), 10.0F);
    EXPECT_EQ(gets(statics, 0.0F, 150), 40.0F);
}

/// Twenty agents that have no map, seen or not.
class Mapless {
  public:
    Mapless(Brain brain, std::vector<motion::StaticBox> boxes, bool seen) {
        field.statics = world_of(std::move(boxes));
        field.settings.brains = {std::move(brain)};
        field.settings.viewer_range_m = seen ? std::numeric_limits<float>::infinity() : 50.0F;
        field.solid = true;
        for (world::EntityType& type : field.types) {
            type.character.acceleration = 20.0F;
        }
        compile(field.settings, kDt);
        for (std::uint32_t id = 1; id <= kAgents; ++id) {
            const auto n = static_cast<float>(id);
            field.add_npc(id, kGuard, 0, Vec3(-8.0F + 0.05F * n, 0.9F, 0.3F * n - 3.0F));
            field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
        }
    }

    [[nodiscard]] Agent& agent(std::uint32_t id) { return *field.agents.find(EntityId(id)); }

    /// Of its body where it has one.
    [[nodiscard]] Vec2 place(std::uint32_t id) {
        const Vec3& body = field.position(id);
        const Vec2 at(body.x(), body.z());
        return agent(id).tier == Tier::kSuspended ? whereabouts(agent(id), at, field.now, kDt) : at;
    }

    static constexpr std::uint32_t kAgents = 20;
    Field field;
};

/// A room of 24 m by 20 m around the agents, from whose walls they want to go.
std::vector<motion::StaticBox> room() {
    return {slab({-12.0F, 1.0F, 0.0F}, {0.2F, 1.0F, 10.2F}),
            slab({12.0F, 1.0F, 0.0F}, {0.2F, 1.0F, 10.2F}),
            slab({0.0F, 1.0F, -10.0F}, {12.2F, 1.0F, 0.2F}),
            slab({0.0F, 1.0F, 10.0F}, {12.2F, 1.0F, 0.2F})};
}

TEST(WalkersWithoutMap, StayInTheirRoom) {
    for (const ActionKind action :
         {ActionKind::kWander, ActionKind::kPatrol, ActionKind::kReturn}) {
        for (const bool seen : {true, false}) {
            Mapless many(single(action, 40.0F), room(), seen);
            for (std::uint32_t id = 1; id <= Mapless::kAgents; ++id) {
                many.agent(id).home += Vec3(action == ActionKind::kReturn ? 40.0F : 0.0F, 0, 0);
            }
            Vec2 most = Vec2::Zero();
            double moved = 0.0;
            for (int second = 0; second < 300; ++second) {
                const Vec2 before = many.place(1);
                many.field.run(1.0F);
                moved += (many.place(1) - before).norm();
                for (std::uint32_t id = 1; id <= Mapless::kAgents; ++id) {
                    most = most.cwiseMax(many.place(id).cwiseAbs());
                }
            }
            // A timetable may lead as deep into walls as WalkAhead says, and a tick farther: 0.13
            // m.
            const float past = seen ? 0.01F : 0.45F;
            EXPECT_LT(most.x(), 11.8F - kWalkerRadius + past) << static_cast<int>(action) << seen;
            EXPECT_LT(most.y(), 9.8F - kWalkerRadius + past) << static_cast<int>(action) << seen;
            EXPECT_EQ(many.field.agents.active().empty(), !seen);
            EXPECT_GT(moved, 30.0) << "they keep walking; " << static_cast<int>(action) << seen;
        }
    }
}

/// Small ones, in a room of walls of 5 cm: a timetable that leads through them leads nobody out.
TEST(WalkersWithoutMap, StayBehindThinWalls) {
    std::vector<motion::StaticBox> walls = room();
    walls[0].half_extents.x() = walls[1].half_extents.x() = 0.025F;
    walls[2].half_extents.z() = walls[3].half_extents.z() = 0.025F;
    Mapless many(single(ActionKind::kWander, 40.0F), walls, false);
    motion::CharacterLimits& limits = many.field.types[kGuard].character;
    limits.radius = 0.1F;
    limits.half_segment = 0.05F;
    for (std::uint32_t id = 1; id <= Mapless::kAgents; ++id) {
        many.field.position(id).y() = 0.15F;
    }
    for (int second = 0; second < 300; ++second) {
        many.field.run(1.0F);
        for (std::uint32_t id = 1; id <= Mapless::kAgents; ++id) {
            const Vec3& body = many.field.position(id);
            ASSERT_LT(std::abs(body.x()), 12.0F) << id << " after " << second;
            ASSERT_LT(std::abs(body.z()), 10.0F) << id << " after " << second;
        }
    }
}

/// Home lies behind a wall of 12 m.
TEST(WalkersWithoutMap, GetRoundAWall) {
    for (const bool seen : {true, false}) {
        Mapless many(single(ActionKind::kReturn), {slab({0, 1, 0}, {0.2F, 1.0F, 6.0F})}, seen);
        for (std::uint32_t id = 1; id <= Mapless::kAgents; ++id) {
            many.agent(id).home = Vec3(8.0F, 0.9F, 0.3F * static_cast<float>(id) - 3.0F);
        }
        many.field.run(240.0F);
        for (std::uint32_t id = 1; id <= Mapless::kAgents; ++id) {
            const Vec2 home(many.agent(id).home.x(), many.agent(id).home.z());
            EXPECT_LT((many.place(id) - home).norm(), 2.0F * kArriveM) << id << seen;
        }
    }
}

}  // namespace
}  // namespace zoned::ai
