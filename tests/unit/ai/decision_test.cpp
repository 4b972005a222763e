#include "server/ai/agent/decision.h"

#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::ai::test {
namespace {

/// Transitions that a lone agent makes while the player stands at `distance(decision)`.
template <class Distance>
int transitions_of(const Brain& brain, int decisions, Distance&& distance) {
    Agent agent;
    agent.entity = EntityId(1);
    agent.rng = core::Rng(1);
    int count = 0;
    for (int i = 0; i < decisions; ++i) {
        Percept percept;
        percept.distance = distance(i);
        count += decide(agent, brain, percept, Vec3(5.0F, 0.0F, 0.0F), i * 6, kDt) ? 1 : 0;
    }
    return count;
}

TEST(Decision, DoesNotOscillateWithAPlayerAtTheThresholdAndNoise) {
    core::Rng noise(3);
    // Noise of +-2 m is less than the 5 m between the two thresholds: once it chases it never
    // leaves.
    EXPECT_LE(
        transitions_of(guard_brain(), 2000, [&](int) { return 15.0F + noise.range(-2.0F, 2.0F); }),
        1);
    EXPECT_LE(
        transitions_of(guard_brain(), 2000, [&](int) { return 20.0F + noise.range(-2.0F, 2.0F); }),
        1);
}

TEST(Decision, WouldOscillateWithoutHysteresis) {
    // The same noise with one threshold and no hold: the test above protects from this.
    Brain brain = guard_brain();
    for (BrainState& state : brain.states) {
        for (Transition& transition : state.transitions) {
            transition.hold_s = 0.0F;
            if (transition.sensor == Sensor::kPlayerDistance) {
                transition.threshold = 15.0F;
            }
        }
    }
    core::Rng noise(3);
    EXPECT_GT(transitions_of(brain, 2000, [&](int) { return 15.0F + noise.range(-2.0F, 2.0F); }),
              100);
}

TEST(Decision, NeedsTheConditionToHoldWithoutInterruption) {
    // Decisions come every 0.2 s; 0.4 s of holding are never reached when each third one fails.
    EXPECT_EQ(transitions_of(guard_brain(), 600, [](int i) { return i % 3 == 2 ? 30.0F : 5.0F; }),
              0);
    EXPECT_EQ(transitions_of(guard_brain(), 600, [](int) { return 5.0F; }), 1);
}

TEST(Decision, FiresAfterExactlyTheHoldTime) {
    Agent agent;
    agent.entity = EntityId(1);
    const Brain brain = guard_brain();
    Percept near;
    near.distance = 1.0F;
    EXPECT_FALSE(decide(agent, brain, near, Vec3::Zero(), 0, kDt));
    EXPECT_FALSE(decide(agent, brain, near, Vec3::Zero(), 6, kDt));
    EXPECT_TRUE(decide(agent, brain, near, Vec3::Zero(), 12, kDt));
    EXPECT_EQ(agent.state_machine.leaf, kOnChase);
    EXPECT_EQ(agent.state_machine.since[0], 12);
}

TEST(Decision, TakesAnImmediateTransitionWhileAnotherIsHeld) {
    Brain brain = single(ActionKind::kIdle);
    brain.states.resize(3);
    brain.states[0].transitions = {{1, Sensor::kPlayerDistance, Compare::kBelow, 10.0F, 5.0F},
                                   {2, Sensor::kTimeInState, Compare::kAbove, 1.0F, 0.0F}};
    Agent agent;
    agent.entity = EntityId(1);
    Percept near;
    near.distance = 1.0F;
    Tick now = 0;
    while (!decide(agent, brain, near, Vec3::Zero(), now, kDt)) {
        now += 6;
        ASSERT_LT(now, 100);
    }
    EXPECT_EQ(agent.state_machine.leaf, 2);
    EXPECT_EQ(now, 36);  // the first decision later than 1 s
}

TEST(Decision, DrawsTheRandomSensorWithItsProbability) {
    Brain brain = single(ActionKind::kIdle);
    brain.states[0].transitions = {{0, Sensor::kRandom, Compare::kBelow, 0.1F, 0.0F}};
    // Binomial with n = 10,000 and p = 0.1: mean 1,000, deviation 30; five deviations.
    EXPECT_NEAR(transitions_of(brain, 10000, [](int) { return 0.0F; }), 1000, 150);
}

TEST(Decision, SpreadsAgentsOverThePeriodByTheirId) {
    for (std::uint32_t id = 1; id < 50; ++id) {
        const Tick next = next_decision(EntityId(id), 6, 100);
        EXPECT_GT(next, 100);
        EXPECT_LE(next, 106);
        EXPECT_EQ(next % 6, id % 6);
        EXPECT_EQ(next_decision(EntityId(id), 6, next), next + 6);
    }
}

class Budget : public ::testing::TestWithParam<int> {};

TEST_P(Budget, LetsNobodyWaitLongerThanAllOthersTogetherNeed) {
    constexpr int kAgents = 97;
    Field field;
    field.settings.brains = {single(ActionKind::kIdle)};
    field.settings.brains[0].decide_every_s = kDt;  // all agents want to decide in every tick
    field.settings.max_decisions_per_tick = static_cast<std::uint32_t>(GetParam());
    for (std::uint32_t id = 1; id <= kAgents; ++id) {
        field.add_npc(id, kGuard, 0, Vec3(static_cast<float>(id), 0.0F, 0.0F));
    }
    const Tick bound = (kAgents + GetParam() - 1) / GetParam();
    Tick longest = 0;
    for (int tick = 0; tick < 400; ++tick) {
        std::vector<Tick> due;
        for (std::size_t i = 0; i < kAgents; ++i) {
            due.push_back(field.agents.at(field.agents.nth(i)).next_decision);
        }
        const AiReport report = field.step();
        EXPECT_LE(report.decisions, static_cast<std::uint32_t>(GetParam()));
        for (std::size_t i = 0; i < due.size(); ++i) {
            if (field.agents.at(field.agents.nth(i)).next_decision == due[i]) {
                longest = std::max(longest, field.now - due[i]);  // still waiting
            }
        }
    }
    EXPECT_LE(longest, bound);
    EXPECT_GE(longest, bound - 2);  // the budget was really short
}

INSTANTIATE_TEST_SUITE_P(Sizes, Budget, ::testing::Values(1, 3, 10, 50));

TEST(Budget, ReportsWhatItPostponed) {
    Field field;
    field.settings.brains = {single(ActionKind::kIdle)};
    field.settings.max_decisions_per_tick = 4;
    for (std::uint32_t id = 1; id <= 10; ++id) {
        field.add_npc(id, kGuard, 0, Vec3::Zero());
    }
    const AiReport report = field.step();
    EXPECT_EQ(report.agents, 10u);
    EXPECT_EQ(report.decisions, 4u);
    EXPECT_EQ(report.postponed, 6u);
}

}  // namespace
}  // namespace zoned::ai::test
