#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace zoned::ai::test {
namespace {

Brain sheep_brain() {
    Brain brain;
    brain.name = "sheep";
    brain.perception_m = 20.0F;
    brain.states.resize(3);
    brain.states[0].action = ActionKind::kFlock;
    brain.states[0].radius_m = 10.0F;
    brain.states[0].speed_factor = 0.5F;
    brain.states[0].transitions = {{1, Sensor::kPlayerDistance, Compare::kBelow, 8.0F, 0.0F},
                                   {2, Sensor::kRandom, Compare::kBelow, 0.02F, 0.0F}};
    brain.states[1].action = ActionKind::kFlee;
    brain.states[1].transitions = {{0, Sensor::kPlayerDistance, Compare::kAbove, 14.0F, 1.0F}};
    brain.states[2].action = ActionKind::kIdle;
    brain.states[2].transitions = {{0, Sensor::kTimeInState, Compare::kAbove, 2.0F, 0.0F}};
    return brain;
}

struct Planned {
    std::uint32_t id;
    TypeIndex type;
    std::uint16_t brain;
    Vec3 position;
};

/// 20 guards, 40 sheep, 20 wanderers.
std::vector<Planned> plan() {
    std::vector<Planned> planned;
    core::Rng rng(11);
    for (std::uint32_t id = 1; id <= 80; ++id) {
        const std::uint16_t brain = id <= 20 ? 0 : (id <= 60 ? 1 : 2);
        const TypeIndex type = brain == 1 ? kSheep : kGuard;
        planned.push_back(
            {id, type, brain, Vec3(rng.range(-60.0F, 60.0F), 0.0F, rng.range(-60.0F, 60.0F))});
    }
    return planned;
}

void furnish(Field& field) {
    field.settings.brains = {guard_brain(), sheep_brain(), single(ActionKind::kWander)};
    field.settings.max_decisions_per_tick = 9;  // fewer than the 80 / 6 that want to
    field.settings.far_m = 50.0F;
}

void populate(Field& field, const std::vector<std::size_t>& order) {
    const std::vector<Planned> planned = plan();
    for (const std::size_t i : order) {
        field.add_npc(planned[i].id, planned[i].type, planned[i].brain, planned[i].position);
    }
}

void move_players(Field& field) {
    for (std::uint32_t id = 101; id <= 104; ++id) {
        const float t = static_cast<float>(field.now) * kDt;
        field.position(id) = Vec3(40.0F * std::sin(0.3F * t + static_cast<float>(id)),
                                  0.0F,
                                  40.0F * std::cos(0.21F * t * static_cast<float>(id - 100)));
    }
}

std::vector<std::size_t> straight() {
    std::vector<std::size_t> order(80);
    std::iota(order.begin(), order.end(), std::size_t{0});
    return order;
}

std::uint64_t hash_of(Field& field) {
    core::StateHash hash;
    field.agents.hash(hash);
    for (std::uint32_t id = 1; id <= 80; ++id) {
        hash.add(field.position(id).x());
        hash.add(field.position(id).z());
        hash.add(field.command(id).yaw);
    }
    return hash.value();
}

TEST(AgentStore, AreIndependentOfInsertionHistory) {
    Field a;
    furnish(a);
    populate(a, straight());
    Field b;
    furnish(b);
    std::vector<std::size_t> order = straight();
    core::Rng shuffle(4);
    for (std::size_t i = order.size(); i > 1; --i) {
        std::swap(order[i - 1], order[shuffle.below(static_cast<std::uint32_t>(i))]);
    }
    for (std::uint32_t id = 101; id <= 104; ++id) {
        a.add_player(id, Vec3::Zero());
        b.add_player(205 - id, Vec3::Zero());  // rows in another order
    }
    populate(b, order);
    std::uint32_t transitions = 0;
    for (int tick = 0; tick < 1800; ++tick) {
        move_players(a);
        move_players(b);
        transitions += a.step().transitions;
        b.step();
        ASSERT_EQ(hash_of(a), hash_of(b)) << "tick " << tick;
    }
    EXPECT_GT(transitions, 100u);
}

TEST(AgentStore, BehaveTheSameWhenTakenAndAddedAgain) {
    Field a;
    Field b;
    for (Field* field : {&a, &b}) {
        furnish(*field);
        populate(*field, straight());
        for (std::uint32_t id = 101; id <= 104; ++id) {
            field->add_player(id, Vec3::Zero());
        }
    }
    core::Rng pick(6);
    for (int tick = 0; tick < 1200; ++tick) {
        const EntityId moved(1 + pick.below(80));
        b.agents.add(b.agents.take(moved));
        move_players(a);
        move_players(b);
        a.step();
        b.step();
        ASSERT_EQ(hash_of(a), hash_of(b)) << "tick " << tick;
    }
}

TEST(AgentStore, BehaveTheSameInAZoneWithAnotherOrigin) {
    // Whole metres of offset keep floats nearly exact; the paths agree but for rounding.
    Field a;
    Field b;
    const Vec3 offset(512.0F, 0.0F, -256.0F);
    for (Field* field : {&a, &b}) {
        furnish(*field);
        field->add_npc(1, kGuard, 0, Vec3::Zero());
        field->run(7.0F);
    }
    Agent agent = b.agents.take(EntityId(1));
    shift(agent, offset);
    b.agents.add(agent);
    b.position(1) += offset;
    a.run(20.0F);
    b.run(20.0F);
    EXPECT_EQ(a.agents.find(EntityId(1))->corner, b.agents.find(EntityId(1))->corner);
    EXPECT_LT((b.position(1) - offset - a.position(1)).norm(), 0.05F);
}

TEST(AgentStore, HashSeesEveryField) {
    Agent agent;
    agent.entity = EntityId(1);
    const auto hash = [](const Agent& m) {
        AgentStore agents;
        agents.add(m);
        core::StateHash h;
        agents.hash(h);
        return h.value();
    };
    const std::uint64_t before = hash(agent);
    std::vector<Agent> changed(37, agent);
    changed[0].brain = 1;
    changed[1].state_machine.leaf = 1;
    changed[2].state_machine.since[0] = 1;
    changed[3].next_decision = 1;
    changed[4].state_machine.since[3] = 1;
    changed[5].state_machine.pending = 1;
    changed[6].home.x() = 1.0F;
    changed[7].target.z() = 1.0F;
    changed[8].corner = 1;
    changed[9].prey = EntityId(3);
    changed[10].rng.next();
    changed[11].entered = false;
    changed[12].fresh = false;
    changed[13].far = true;
    changed[14].aim.move_x = 1;
    changed[15].anchor.y() = 1.0F;
    changed[16].anchor_since = 1;
    changed[17].detour_until = 1;
    changed[18].state_machine.memory[0] = 1;
    changed[19].state_machine.memory[7] = 1;
    changed[20].variables[7] = 1.0F;
    changed[21].variables_at = 1;
    changed[22].current_action = 1;
    changed[23].facts = 1;
    changed[24].tier = Tier::kSuspended;
    changed[25].offscreen_since = 1;
    changed[26].segment.from.x() = 1.0F;
    changed[27].segment.direction.y() = 1.0F;
    changed[28].segment.length = 1.0F;
    changed[29].segment.speed = 1.0F;
    changed[30].segment.bend_s = 1.0F;
    changed[31].segment.since = 1;
    changed[32].next_event = 1;
    changed[33].next_steering = 1;
    changed[34].segment.bend.y() = 1.0F;
    changed[35].timed = true;
    changed[36].segment.goal.x() = 1.0F;
    for (std::size_t i = 0; i < changed.size(); ++i) {
        EXPECT_NE(hash(changed[i]), before) << i;
    }
    // Since when a transition is held counts while one is.
    Agent held = agent;
    held.state_machine.pending = 1;
    Agent longer = held;
    longer.state_machine.pending_since = -5;
    EXPECT_NE(hash(held), hash(longer));
}

TEST(AgentStore, LeaveHiddenGhostAndMissingEntitiesAlone) {
    Field field;
    field.settings.brains = {single(ActionKind::kWander)};
    for (std::uint32_t id = 1; id <= 3; ++id) {
        field.add_npc(id, kGuard, 0, Vec3::Zero());
    }
    field.entities.set(0, world::kHidden, true);
    field.entities.set(1, world::kGhost, true);
    field.entities.remove(2);
    const AiReport report = field.step();
    EXPECT_EQ(report.decisions, 0u);
    EXPECT_EQ(report.steered, 0u);
    EXPECT_EQ(field.command(1), motion::InputCommand{});
    EXPECT_EQ(field.command(2), motion::InputCommand{});
}

TEST(LevelOfDetail, LetsFarAgentsSteerEveryFourthTickInTurns) {
    Field field;
    field.settings.brains = {single(ActionKind::kWander)};
    for (std::uint32_t id = 1; id <= 40; ++id) {
        field.add_npc(id, kGuard, 0, Vec3(static_cast<float>(id), 0.0F, 0.0F));
    }
    const world::Row player = field.add_player(50, Vec3(1000.0F, 0.0F, 0.0F));
    field.run(1.0F);
    for (int tick = 0; tick < 20; ++tick) {
        // Also agents that reach their targets in between: one in some seconds each.
        const std::uint32_t steered = field.step().steered;
        EXPECT_GE(steered, 10u);
        EXPECT_LE(steered, 14u);
    }
    field.entities.position[player] = Vec3::Zero();
    field.run(1.0F);
    EXPECT_EQ(field.step().steered, 40u);
    field.settings.reduce_far = false;
    field.entities.position[player] = Vec3(1000.0F, 0.0F, 0.0F);
    field.run(1.0F);
    EXPECT_EQ(field.step().steered, 40u);
}

}  // namespace
}  // namespace zoned::ai::test
