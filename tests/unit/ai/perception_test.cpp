// Perception: sight, hearing and memory against distances and angles worked out by hand, and the
// budget of rays.
#include "server/ai/perception/perception.h"

#include "server/physics/scene/scene.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace zoned::ai::test {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A guard, entity 1, at the origin, who looks along +z.
struct Watch {
    Field field;
    Brain brain = single(ActionKind::kIdle);
    Agent agent;
    physics::Scene scene{physics::PhysicsSettings{}};
    bool walls = false;

    Watch() {
        brain.perception.given = true;
        field.entities.add(EntityId(1), kGuard);
        agent.entity = EntityId(1);
        field.types[kPlayer].aura_m.fill(20.0F);
        field.types[kPlayer].aura_m[1] = 6.0F;
        field.types[kPlayer].character.sprint_factor = 1.6F;
    }

    world::Row add(std::uint32_t id, TypeIndex type, float x, float z) {
        const world::Row row = field.entities.add(EntityId(id), type);
        field.entities.position[row] = Vec3(x, 0.0F, z);
        if (type == kPlayer) {
            field.entities.set_client(row, ClientId(id));
        }
        return row;
    }

    void add_wall(const Vec3& centre, const Vec3& half) {
        physics::BodyDef def;
        def.kind = physics::BodyKind::kStatic;
        def.shape = physics::Shape::box(half);
        def.position = centre;
        ASSERT_TRUE(scene.add(def).ok());
        walls = true;
    }

    Percept look() {
        field.grid.build(field.entities.position, 8.0F);
        const physics::Query query = scene.query();
        const CompiledBrain compiled = compile(brain, kDt);
        AiContext ai = field.context();
        ai.query = walls ? &query : nullptr;
        const Percept percept = perceive(ai, field.entities.find(EntityId(1)), agent, compiled);
        take_notice(agent, percept, compiled, field.now);
        return percept;
    }

    void place(std::uint32_t id, float x, float z) { field.position(id) = Vec3(x, 0.0F, z); }
};

float degrees(float angle) {
    return angle * std::numbers::pi_v<float> / 180.0F;
}

TEST(Perception, WithoutSettingsIsTheNearestPlayerAsEver) {
    Watch watch;
    watch.brain.perception = Perception{};
    watch.add(2, kPlayer, 3.0F, -4.0F);
    watch.add(3, kPlayer, 30.0F, 0.0F);
    watch.add(4, kSheep, 1.0F, 0.0F);
    const Percept percept = watch.look();
    EXPECT_EQ(percept.prey, EntityId(2));
    EXPECT_EQ(percept.distance, 5.0F);
    EXPECT_EQ(percept.confidence, 1.0F);
    EXPECT_EQ(percept.foes, 2.0F);
    EXPECT_TRUE(watch.agent.noticed);
    EXPECT_EQ(watch.agent.known_at, 0) << "nothing is remembered that nobody asked for";
}

TEST(Percept, IsAConeAboutTheFacingAndAllRoundNearby) {
    Watch watch;
    watch.brain.perception.cos_half_angle = std::cos(degrees(60.0F));
    watch.brain.perception.around_m = 3.0F;
    watch.add(2, kPlayer, 0.0F, 10.0F);
    EXPECT_EQ(watch.look().prey, EntityId(2));
    for (const float side : {-1.0F, 1.0F}) {
        watch.place(2, side * 10.0F * std::sin(degrees(59.0F)), 10.0F * std::cos(degrees(59.0F)));
        EXPECT_EQ(watch.look().prey, EntityId(2));
        watch.place(2, side * 10.0F * std::sin(degrees(61.0F)), 10.0F * std::cos(degrees(61.0F)));
        EXPECT_EQ(watch.look().prey, EntityId());
    }
    watch.place(2, 0.0F, -2.9F);
    EXPECT_EQ(watch.look().prey, EntityId(2)) << "behind, but within reach";
    watch.place(2, 0.0F, -3.1F);
    EXPECT_EQ(watch.look().prey, EntityId());
    // A quarter turn about +y looks along +x.
    watch.field.entities.yaw[0] = 16384;
    watch.place(2, 10.0F, 0.0F);
    EXPECT_EQ(watch.look().prey, EntityId(2));
    watch.place(2, 41.0F, 0.0F);
    EXPECT_EQ(watch.look().prey, EntityId()) << "beyond perception_m";
}

TEST(Percept, EndsAtWallsUnlessEyesLookOverThem) {
    Watch watch;
    watch.brain.perception.line_of_sight = true;
    watch.add(2, kPlayer, 0.0F, 10.0F);
    watch.add(3, kPlayer, 8.0F, 10.0F);
    watch.add_wall(Vec3(0.0F, 0.0F, 5.0F), Vec3(2.0F, 1.0F, 0.2F));
    // The ray to the third passes the wall's plane at x = 4, beside its end at 2.
    const Percept percept = watch.look();
    EXPECT_EQ(percept.prey, EntityId(3));
    EXPECT_EQ(percept.foes, 2.0F);
    watch.brain.perception.eyes_m = 1.1F;
    EXPECT_EQ(watch.look().prey, EntityId(2));
    // A body that is not static hides no one.
    watch.brain.perception.eyes_m = 0.6F;
    watch.place(2, 0.0F, 4.0F);
    physics::BodyDef def;
    def.shape = physics::Shape::box(Vec3(2.0F, 1.0F, 0.2F));
    def.position = Vec3(0.0F, 0.0F, 2.0F);
    ASSERT_TRUE(watch.scene.add(def).ok());
    EXPECT_EQ(watch.look().prey, EntityId(2));
}

TEST(Percept, LooksAtTheTargetOfBeforeAndTheThreeNearestOthers) {
    Watch watch;
    watch.brain.perception.line_of_sight = true;
    // Five stand behind one another, all behind a wall, the sixth beside it and farther.
    for (std::uint32_t id = 2; id <= 6; ++id) {
        watch.add(id, kPlayer, 0.0F, 8.0F + static_cast<float>(id));
    }
    watch.add(7, kPlayer, 20.0F, 20.0F);
    watch.add_wall(Vec3(0.0F, 0.0F, 5.0F), Vec3(2.0F, 1.0F, 0.2F));
    EXPECT_EQ(watch.look().prey, EntityId()) << "four rays, and all of them end at the wall";
    watch.agent.prey = EntityId(7);
    EXPECT_EQ(watch.look().prey, EntityId(7)) << "one of them is for the target of before";
}

TEST(Hearing, ReachesAsFarAsTheAuraTimesTheShareOfWalking) {
    Watch watch;
    watch.brain.perception.cos_half_angle = std::cos(degrees(10.0F));
    watch.brain.perception.hearing_m = 25.0F;
    const world::Row row = watch.add(2, kPlayer, 0.0F, -10.0F);  // behind
    const auto heard = [&](float distance, float speed) {
        watch.place(2, 0.0F, -distance);
        watch.field.entities.velocity[row] = Vec3(speed, 3.0F, 0.0F);  // a fall is silent
        return static_cast<bool>(watch.look().prey);
    };
    EXPECT_TRUE(heard(19.9F, 5.0F));  // walking: the aura, 20 m
    EXPECT_FALSE(heard(20.1F, 5.0F));
    EXPECT_TRUE(heard(9.9F, 2.5F));  // half as fast: half as far
    EXPECT_FALSE(heard(10.1F, 2.5F));
    EXPECT_FALSE(heard(1.0F, 0.0F));
    EXPECT_TRUE(heard(24.9F, 8.0F));  // a sprint carries 32 m, but ears reach 25
    EXPECT_FALSE(heard(25.1F, 8.0F));
    watch.field.entities.stance[row] = 1;  // a quiet stance: 6 m
    EXPECT_TRUE(heard(5.9F, 5.0F));
    EXPECT_FALSE(heard(6.1F, 5.0F));
}

TEST(Memory, KnowsWhereATargetWasWithLessAndLessConfidence) {
    Watch watch;
    watch.brain.perception.cos_half_angle = 0.0F;
    watch.brain.perception.memory_s = 4.0F;
    watch.field.now = 30;
    watch.add(2, kPlayer, 3.0F, 4.0F);
    EXPECT_EQ(watch.look().confidence, 1.0F);
    watch.place(2, 0.0F, -20.0F);
    watch.field.now = 60;  // 1 of 4 s
    Percept percept = watch.look();
    EXPECT_EQ(percept.prey, EntityId(2));
    EXPECT_FALSE(percept.noticed);
    EXPECT_NEAR(percept.confidence, 0.75F, 1e-6F);
    EXPECT_EQ(percept.distance, 5.0F);
    EXPECT_EQ(percept.place, Vec3(3.0F, 0.0F, 4.0F));
    watch.field.now = 149;
    EXPECT_NEAR(watch.look().confidence, 1.0F / 120.0F, 1e-5F);
    watch.field.now = 150;
    percept = watch.look();
    EXPECT_EQ(percept.prey, EntityId());
    EXPECT_EQ(percept.confidence, 0.0F);
    EXPECT_EQ(percept.distance, kInfinity);
    watch.field.now = 151;
    EXPECT_EQ(watch.look().prey, EntityId()) << "what was forgotten stays forgotten";
}

TEST(Memory, GivesWayToWhomIsNoticed) {
    Watch watch;
    watch.brain.perception.cos_half_angle = 0.0F;
    watch.brain.perception.memory_s = 4.0F;
    watch.field.now = 30;
    watch.add(2, kPlayer, 0.0F, 4.0F);
    watch.look();
    watch.place(2, 0.0F, -4.0F);
    watch.add(3, kPlayer, 0.0F, 30.0F);
    EXPECT_EQ(watch.look().prey, EntityId(3));
}

TEST(Targets, AreOfTheTypesThatAreNamed) {
    Watch watch;
    watch.brain.perception.players = false;
    watch.brain.perception.targets = {kSheep};
    watch.brain.perception.allies = {kGuard};
    watch.add(2, kPlayer, 1.0F, 0.0F);
    watch.add(9, kSheep, 0.0F, 6.0F);
    watch.add(8, kSheep, 6.0F, 0.0F);
    watch.add(7, kSheep, 0.0F, 41.0F);
    watch.add(11, kGuard, 0.0F, 39.0F);
    watch.add(12, kGuard, 0.0F, 41.0F);
    const world::Row hidden = watch.add(4, kSheep, 1.0F, 1.0F);
    watch.field.entities.set(hidden, world::kHidden, true);
    const Percept percept = watch.look();
    EXPECT_EQ(percept.prey, EntityId(8)) << "of equals the smaller id";
    EXPECT_EQ(percept.distance, 6.0F);
    EXPECT_EQ(percept.foes, 2.0F);
    EXPECT_EQ(percept.allies, 1.0F) << "it is none of its own";
    EXPECT_FALSE(percept.player_far);
}

TEST(Targets, AreKeptWhereTheBrainSaysSo) {
    Watch watch;
    watch.add(2, kPlayer, 0.0F, 10.0F);
    EXPECT_EQ(watch.look().prey, EntityId(2));
    watch.add(3, kPlayer, 0.0F, 5.0F);
    EXPECT_EQ(watch.look().prey, EntityId(3));
    watch.brain.perception.keeps_target = true;
    watch.agent.prey = EntityId(2);
    EXPECT_EQ(watch.look().prey, EntityId(2));
    watch.place(2, 0.0F, 50.0F);
    EXPECT_EQ(watch.look().prey, EntityId(3));
}

TEST(Wards, AreKnownAllRoundAndKept) {
    Watch watch;
    watch.brain.perception.cos_half_angle = 0.9F;
    watch.brain.perception.wards = {kSheep};
    watch.add(2, kSheep, 0.0F, -10.0F);
    EXPECT_EQ(watch.look().ward, EntityId(2));
    watch.add(3, kSheep, 0.0F, -5.0F);
    EXPECT_EQ(watch.look().ward, EntityId(2));
    watch.place(2, 0.0F, -41.0F);
    EXPECT_EQ(watch.look().ward, EntityId(3));
}

TEST(Perception, DoesNotDependOnTheOrderOfRows) {
    std::vector<std::uint32_t> order(60);
    std::iota(order.begin(), order.end(), 2U);
    core::Rng rng(5);
    std::optional<Percept> first;
    for (int trial = 0; trial < 20; ++trial) {
        Watch watch;
        watch.brain.perception.line_of_sight = true;
        watch.brain.perception.targets = {kSheep};
        watch.brain.perception.wards = {kGuard};
        watch.add_wall(Vec3(0.0F, 0.0F, 5.0F), Vec3(4.0F, 1.0F, 0.2F));
        for (const std::uint32_t id : order) {
            // Many at the same distance: places on a coarse lattice.
            watch.add(id,
                      static_cast<TypeIndex>(id % 3),
                      static_cast<float>(id * 7 % 11) - 5.0F,
                      static_cast<float>(id * 5 % 13) - 2.0F);
        }
        const Percept percept = watch.look();
        first = first ? first : percept;
        EXPECT_EQ(percept.prey, first->prey);
        EXPECT_EQ(percept.ward, first->ward);
        EXPECT_EQ(percept.foes, first->foes);
        for (std::size_t i = order.size() - 1; i > 0; --i) {
            std::swap(order[i], order[rng.below(static_cast<std::uint32_t>(i + 1))]);
        }
    }
    EXPECT_TRUE(first->prey);
}

TEST(RayBudget, IsSharedFairlyAndWhoWaitsGoesOnWithWhatItKnew) {
    Field field;
    Brain brain = single(ActionKind::kIdle);
    brain.decide_every_s = kDt;  // all agents want to look in every tick
    brain.perception.given = true;
    brain.perception.line_of_sight = true;
    field.settings.brains = {brain, single(ActionKind::kIdle)};
    field.settings.brains[1].decide_every_s = kDt;
    field.settings.max_sight_rays_per_tick = 3 * kRaysPerLook + 1;  // three looks
    constexpr std::uint32_t kAgents = 40;
    for (std::uint32_t id = 1; id <= kAgents; ++id) {
        field.add_npc(id, kGuard, 0, Vec3(static_cast<float>(id), 0.0F, 0.0F));
    }
    field.add_npc(50, kGuard, 1, Vec3::Zero());
    std::map<std::uint32_t, Tick> waits;
    Tick longest = 0;
    for (int t = 0; t < 200; ++t) {
        const AiReport report = field.step();
        EXPECT_EQ(report.decisions, 4U) << "three that look, and one that needs no ray";
        EXPECT_EQ(report.blinded, kAgents - 3U);
        for (const Slot slot : field.agents.active()) {
            longest = std::max(longest, field.now - field.agents.at(slot).next_decision);
        }
    }
    // 40 agents, three a tick: each comes after at most ceil(40 / 3) ticks.
    EXPECT_LE(longest, 14);
    EXPECT_GE(longest, 13) << "the test would not see who waits for ever";
}

}  // namespace
}  // namespace zoned::ai::test
