// Agents that walk along paths: around walls, through doors, and alike on-screen and off-screen.
#include "server/ai/steering/path_following.h"

#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

namespace zoned::ai {
namespace {

using namespace test;

motion::StaticBox block(float x, float z, float half_x, float half_z) {
    motion::StaticBox box;
    box.centre = Vec3(x, 1.0F, z);
    box.half_extents = Vec3(half_x, 2.0F, half_z);
    return box;
}

/// A wall along z at x = 0 from z = -20 to 16.5, with a gate of 3 m at z = 0.
class Yard {
  public:
    /// The gate is open in ticks [opens, shuts) of 10,000.
    Yard(Brain brain, Tick opens, Tick shuts, bool simulated) {
        motion::Door gate;
        gate.box = block(0.0F, 0.0F, 0.2F, 1.5F);
        gate.times.period = 10000;
        gate.times.open = {{opens, shuts}};
        field.statics = {{block(0.0F, -10.75F, 0.2F, 9.25F), block(0.0F, 9.0F, 0.2F, 7.5F)},
                         0.0F,
                         motion::kStaticCell_m,
                         {},
                         {gate}};
        field.settings.brains = {std::move(brain)};
        field.settings.viewer_range_m = simulated ? std::numeric_limits<float>::infinity() : 50.0F;
        field.solid = true;
        for (world::EntityType& type : field.types) {
            type.brain = 1;
            type.character.acceleration = 20.0F;
        }
        field.paths =
            PathService({0.5F, 1'000'000}, field.statics, {-25, -20, 25, 20}, field.types, 0);
        compile(field.settings, kDt);
    }

    /// An agent at (-10, z) whose home is at `home`.
    void add(std::uint32_t id, float z, const Vec2& home) {
        field.add_npc(id, kGuard, 0, Vec3(-10.0F, 0.9F, z));
        agent(id).home = Vec3(home.x(), 0.9F, home.y());
        field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
    }

    [[nodiscard]] Agent& agent(std::uint32_t id) { return *field.agents.find(EntityId(id)); }

    /// The place that its own state gives.
    [[nodiscard]] Vec2 place(std::uint32_t id) {
        const Vec3& body = field.position(id);
        return whereabouts(agent(id), Vec2(body.x(), body.z()), field.now, kDt);
    }

    /// Whether it is in the wall, or in the gate while the gate is shut.
    [[nodiscard]] bool in_wall(std::uint32_t id) {
        const Vec2 at = place(id);
        const bool doorway = std::abs(at.y()) < 1.5F;
        const bool shut = field.statics.shut_at(0, field.now - 1);
        return std::abs(at.x()) < 0.2F && at.y() < 16.5F && (!doorway || shut);
    }

    Field field;
};

Brain homing() {
    Brain brain = single(ActionKind::kReturn);
    brain.states[0].speed_factor = 0.8F;
    return brain;
}

/// By the gap at z = 17 it is 2 sqrt(10^2 + 17^2) = 39.4 m, 12.6 s at 0.8 of 4 m/s; straight 20 m.
TEST(PathFollowing, LeadsRoundAGateThatIsShut) {
    Yard yard(homing(), 9000, 9001, true);
    yard.add(1, 0.0F, {10.0F, 0.0F});
    Tick arrived = 0;
    for (Tick tick = 0; tick < 30 * 20; ++tick) {
        yard.field.step();
        ASSERT_FALSE(yard.in_wall(1)) << tick << " at " << yard.place(1).transpose();
        arrived = arrived == 0 && yard.agent(1).segment.speed == 0.0F ? tick : arrived;
    }
    EXPECT_LT((yard.place(1) - Vec2(10.0F, 0.0F)).norm(), kArriveM);
    const float seconds = static_cast<float>(arrived) * kDt;
    EXPECT_GT(seconds, 12.0F);
    EXPECT_LT(seconds, 12.6F * 1.1F) << "no more than a tenth longer than the shortest path";
}

TEST(PathFollowing, TurnsRoundBeforeAGateThatShutsAndGoesThroughOneThatOpens) {
    // It is 10 m to the gate, 3.1 s: shut before it is there.
    Yard shuts(homing(), 0, 60, true);
    shuts.add(1, 0.0F, {10.0F, 0.0F});
    // Opens while it is on its path round the wall, 4 s from now.
    Yard opens(homing(), 120, 9000, true);
    opens.add(1, 0.0F, {10.0F, 0.0F});
    float farthest = 0.0F;
    for (Tick tick = 0; tick < 30 * 20; ++tick) {
        shuts.field.step();
        opens.field.step();
        ASSERT_FALSE(shuts.in_wall(1)) << tick;
        ASSERT_FALSE(opens.in_wall(1)) << tick;
        farthest = std::max(farthest, opens.place(1).y());
    }
    EXPECT_LT((shuts.place(1) - Vec2(10.0F, 0.0F)).norm(), kArriveM);
    EXPECT_LT((opens.place(1) - Vec2(10.0F, 0.0F)).norm(), kArriveM);
    EXPECT_GT(farthest, 5.0F) << "it had set out for the gap";
    EXPECT_LT(farthest, 14.0F) << "and has turned round";
}

TEST(PathFollowing, StopsWhereNoWayLeadsOnAndGoesOnWhenOneOpens) {
    // A home in a yard of its own, whose gate opens after 20 s.
    Yard yard(homing(), 600, 9000, true);
    std::vector<motion::StaticBox> boxes(yard.field.statics.boxes().begin(),
                                         yard.field.statics.boxes().end());
    boxes.push_back(block(0.0F, 18.5F, 0.2F, 3.0F));
    yard.field.statics = {boxes,
                          0.0F,
                          motion::kStaticCell_m,
                          {},
                          {yard.field.statics.doors().begin(), yard.field.statics.doors().end()}};
    yard.field.paths =
        PathService({0.5F, 1'000'000}, yard.field.statics, {-25, -20, 25, 20}, yard.field.types, 0);
    yard.add(1, 5.0F, {10.0F, 0.0F});
    yard.field.run(19.9F);
    EXPECT_LT(yard.place(1).x(), 0.0F);
    EXPECT_FALSE(moving(yard.agent(1))) << "as near as it gets, it waits";
    // It looks again every 5 s; 11 m at 3.2 m/s.
    yard.field.run(5.0F + 6.0F);
    EXPECT_LT((yard.place(1) - Vec2(10.0F, 0.0F)).norm(), kArriveM);
}

/// Wanders about for a minute, then walks home.
Brain stroller() {
    Brain m;
    m.name = "stroller";
    m.states.resize(2);
    m.states[0].name = "wander";
    m.states[0].action = ActionKind::kWander;
    m.states[0].radius_m = 18.0F;
    m.states[0].speed_factor = 0.5F;
    m.states[0].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 40.0F, 0.0F}};
    m.states[1].name = "home";
    m.states[1].action = ActionKind::kReturn;
    m.states[1].transitions = {{0, Sensor::kHomeDistance, Compare::kBelow, 1.5F, 0.5F}};
    return m;
}

TEST(PathFollowing, IsTheSameWhetherSomebodyLooksOrNot) {
    Yard all(stroller(), 300, 1500, true);
    Yard some(stroller(), 300, 1500, false);
    for (std::uint32_t id = 1; id <= 12; ++id) {
        const auto k = static_cast<float>(id);
        all.add(id, k - 6.0F, {k, 2.0F * k - 12.0F});
        some.add(id, k - 6.0F, {k, 2.0F * k - 12.0F});
    }
    std::size_t suspended = 0;
    std::size_t far = 0;
    float worst = 0.0F;
    for (Tick tick = 0; tick < 30 * 300; ++tick) {
        all.field.step();
        some.field.step();
        for (std::uint32_t id = 1; id <= 12; ++id) {
            ASSERT_EQ(all.field.state(id), some.field.state(id)) << id << " at " << tick;
            ASSERT_FALSE(all.in_wall(id)) << id << " at " << tick;
            ASSERT_FALSE(some.in_wall(id)) << id << " at " << tick;
            suspended += some.agent(id).tier == Tier::kSuspended ? 1U : 0U;
            const Vec3& body = all.field.position(id);
            const float off = (some.place(id) - Vec2(body.x(), body.z())).norm();
            worst = std::max(worst, off);
            far += off > 0.5F ? 1U : 0U;
        }
    }
    EXPECT_GT(suspended, 12U * 8500U);
    // An agent held up by the corner of a wall may lag until a new segment is made, which happens
    // when it steers: every fourth tick of 4 m/s.
    EXPECT_LT(worst, kDriftM + 4.0F * 4.0F * kDt);
    EXPECT_LT(far, suspended / 1000U) << "bodies keep to what is told of them";
}

/// A player on the other side of a wall is chased round its end, 39 m at 4 m/s.
TEST(PathFollowing, LeadsAChaserToItsPrey) {
    Brain brain = single(ActionKind::kChase);
    brain.perception_m = 60.0F;
    Yard yard(brain, 9000, 9001, true);
    yard.add(1, 0.0F, {0.0F, 0.0F});
    yard.field.add_player(900, Vec3(10.0F, 0.9F, 0.0F));
    for (Tick tick = 0; tick < 30 * 14; ++tick) {
        yard.field.step();
        ASSERT_FALSE(yard.in_wall(1)) << tick;
    }
    EXPECT_LT(yard.field.distance(1, 900), 1.5F);
}

}  // namespace
}  // namespace zoned::ai
