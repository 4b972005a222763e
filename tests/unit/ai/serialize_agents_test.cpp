// Agents that are saved and loaded go on bit for bit; bytes that are no agents are refused.
#include "server/ai/serialization/serialize_agents.h"

#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

namespace zoned::ai {
namespace {

using namespace test;

/// Walks and rests by chance and by hunger; half of them are on-screen.
Brain restless() {
    Brain m;
    m.name = "restless";
    m.variables = {{"hunger", 0.2F, 0.02F, 0.0F, 1.0F}};
    m.states.resize(3);
    m.states[0].name = "wander";
    m.states[0].action = ActionKind::kWander;
    m.states[0].radius_m = 15.0F;
    m.states[0].transitions = {{1, Sensor::kRandom, Compare::kBelow, 0.05F, 0.0F},
                               {2, Sensor::kPlayerDistance, Compare::kBelow, 10.0F, 0.4F}};
    m.states[1].name = "rest";
    m.states[1].changes = {{0, -0.05F, 0.0F}};
    m.states[1].transitions = {{0, Sensor::kTimeInState, Compare::kAbove, 3.0F, 0.0F}};
    m.states[2].name = "flee";
    m.states[2].action = ActionKind::kFlee;
    m.states[2].transitions = {{0, Sensor::kPlayerDistance, Compare::kAbove, 20.0F, 0.4F}};
    return m;
}

PoiSettings one_pond() {
    PoiSettings settings;
    settings.points_of_interest = {{"pond", {0.0, 0.0}, 3.0F, {{"fish", 5.0F, 10.0F, 0.1F}}}};
    return settings;
}

void furnish(Field& field) {
    field.settings.brains = {restless()};
    field.settings.viewer_range_m = 50.0F;
    field.points_of_interest = PointsOfInterest(one_pond(), Vec2d::Zero(), kDt);
    compile(field.settings, kDt);
    for (std::uint32_t id = 1; id <= 40; ++id) {
        field.add_npc(id, kGuard, 0, Vec3(6.0F * static_cast<float>(id), 0.9F, 0.0F));
        field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
        begin(*field.agents.find(EntityId(id)), field.settings.compiled[0], 0);
    }
    field.add_player(900, Vec3(20.0F, 0.9F, 5.0F));
}

std::uint64_t hash_of(Field& field) {
    core::StateHash hash;
    field.agents.hash(hash);
    field.points_of_interest.hash(hash);
    for (std::uint32_t id = 1; id <= 40; ++id) {
        hash.add(field.position(id).x());
        hash.add(field.position(id).z());
    }
    return hash.value();
}

TEST(AgentSerialize, WhoIsReadAgainGoesOnBitForBit) {
    Field field;
    furnish(field);
    field.run(20.0F);
    ASSERT_FALSE(field.agents.active().empty());
    ASSERT_LT(field.agents.active().size(), field.agents.size()) << "some are seen, some are not";
    std::vector<std::uint8_t> bytes;
    save_agents(field.agents, field.steps, field.points_of_interest, bytes);

    Field other;
    furnish(other);
    other.now = field.now;
    other.entities = field.entities;
    other.agents = AgentStore();
    ASSERT_EQ(
        load_agents(bytes, other.settings, other.agents, other.steps, other.points_of_interest),
        "");
    for (int tick = 0; tick < 1800; ++tick) {
        field.step();
        other.step();
        ASSERT_EQ(hash_of(field), hash_of(other)) << "tick " << tick;
    }
}

/// Bytes before it: version, difficulty (level, level, two counts, a tick), drift, count.
constexpr std::size_t kFirstAgent = 4 + (2 + 4 + 2 * 4 + 8) + 4 + 4;

class BadAgents : public testing::Test {
  protected:
    BadAgents() {
        furnish(field);
        field.run(3.0F);
        save_agents(field.agents, field.steps, field.points_of_interest, bytes);
    }

    std::string read() {
        AgentStore agents;
        AiUpdate steps;
        PointsOfInterest points_of_interest(one_pond(), Vec2d::Zero(), kDt);
        std::string wrong = load_agents(bytes, field.settings, agents, steps, points_of_interest);
        EXPECT_EQ(agents.size(), wrong.empty() ? 40U : 0U) << "all or nothing";
        return wrong;
    }

    Field field;
    std::vector<std::uint8_t> bytes;
};

TEST_F(BadAgents, AreRefusedWithTheirPlace) {
    EXPECT_EQ(read(), "");
    std::vector<std::uint8_t> whole = bytes;
    bytes[0] = 9;
    EXPECT_EQ(read(), "version 9 of agents, not 7");
    bytes = whole;
    bytes[kFirstAgent + 4] = 7;  // the first agent's brain
    EXPECT_EQ(read(), "agent 0 of entity 1 has a brain that there is not");
    bytes = whole;
    bytes[kFirstAgent + 4 + 2] = 200;  // its state
    EXPECT_EQ(read(), "agent 0 of entity 1 is in a state that there is not");
    bytes = whole;
    bytes.push_back(0);
    EXPECT_EQ(read(), "1 bytes are left over");
    field.settings.compiled[0].states.clear();
    bytes = whole;
    EXPECT_EQ(read(), "agent 0 of entity 1 has a brain that there is not");
}

TEST_F(BadAgents, AreRefusedWhereverTheyEnd) {
    const std::vector<std::uint8_t> whole = bytes;
    for (std::size_t size = 0; size < whole.size(); size += size < 600 ? 1 : 37) {
        bytes.assign(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_NE(read(), "") << size << " of " << whole.size();
    }
}

TEST_F(BadAgents, NeverBreakAnythingWhateverBytesSay) {
    core::Rng rng(3);
    const std::vector<std::uint8_t> whole = bytes;
    int taken = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        bytes = whole;
        for (int k = 0; k < 4; ++k) {
            bytes[rng.below(static_cast<std::uint32_t>(bytes.size()))] =
                static_cast<std::uint8_t>(rng.below(256));
        }
        AgentStore agents;
        AiUpdate steps;
        PointsOfInterest points_of_interest(one_pond(), Vec2d::Zero(), kDt);
        if (load_agents(bytes, field.settings, agents, steps, points_of_interest).empty()) {
            ++taken;
            Field other;
            furnish(other);
            other.now = field.now;
            other.agents = std::move(agents);
            for (int tick = 0; tick < 5; ++tick) {
                other.step();  // goes on from the loaded state
            }
        }
    }
    EXPECT_GT(taken, 0) << "many numbers may be any number";
}

}  // namespace
}  // namespace zoned::ai
