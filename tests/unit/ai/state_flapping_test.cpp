// StateFlapping in a running zone: an agent that goes to and fro is found with both transitions, at
// any index.
#include "server/ai/explain.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

namespace zoned::ai::test {
namespace {

/// In and out of a state by one threshold: right at it, every decision changes its agent.
Brain nervous() {
    Brain brain = single(ActionKind::kIdle);
    brain.name = "nervous";
    brain.states[0].name = "calm";
    brain.states[0].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 0.1F}};
    brain.states.push_back(brain.states[0]);
    brain.states[1].name = "upset";
    brain.states[1].transitions = {{0, Sensor::kRandom, Compare::kBelow, 2.0F}};
    return brain;
}

TEST(StateFlapping, IsFoundWithItsTransitionsAndWhoDoesIt) {
    Field field;
    field.settings.brains = {single(ActionKind::kIdle), nervous()};
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    field.add_npc(7, kGuard, 1, Vec3::Zero());
    // Decisions every 0.2 s, each a change: the sixth is at 1.2 s.
    field.run(1.1F);
    EXPECT_TRUE(field.agents.state_flapping(1).empty());
    field.run(0.4F);
    ASSERT_EQ(field.agents.state_flapping(1).size(), 1U);
    const state_machine::FlappingPair& found = field.agents.state_flapping(1)[0];
    EXPECT_EQ(found.agent, 7U);
    EXPECT_EQ(found.count, 1U);
    EXPECT_TRUE(field.agents.state_flapping(0).empty());
    const Brain& brain = field.settings.brains[1];
    const CompiledBrain& compiled = field.settings.compiled[1];
    EXPECT_EQ(transition_text(brain, compiled, found.a, found.b, found.a_to_b),
              "calm -> upset where time in state above 0.1");
    EXPECT_EQ(transition_text(brain, compiled, found.b, found.a, found.b_to_a),
              "upset -> calm where random below 2");
}

TEST(StateFlapping, FollowsAnAgentWhenOthersComeAndGo) {
    Field field;
    field.settings.brains = {nervous()};
    field.add_npc(7, kGuard, 0, Vec3::Zero());
    field.run(0.6F);
    field.add_npc(3, kGuard, 0, Vec3::Zero());  // before it: every index moves
    field.run(0.9F);
    ASSERT_EQ(field.agents.state_flapping(0).size(), 1U);
    EXPECT_EQ(field.agents.state_flapping(0)[0].agent, 7U);
    // An agent that went and came back counts as another one in reports.
    field.agents.add(field.agents.take(EntityId(7)));
    EXPECT_EQ(field.agents.state_flapping(0)[0].count, 1U);
    field.agents.forget_flapping();
    EXPECT_TRUE(field.agents.state_flapping(0).empty());
}

}  // namespace
}  // namespace zoned::ai::test
