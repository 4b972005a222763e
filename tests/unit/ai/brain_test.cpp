#include "server/ai/agent/brain/brain.h"

#include "server/ai/agent/decision.h"
#include "server/ai/explain.h"
#include "tests/unit/ai/field.h"

#include <gmock/gmock.h>

namespace zoned::ai::test {
namespace {

using testing::HasSubstr;

constexpr SenseIndex kHunger = kOwnSenses;
constexpr SenseIndex kBread = kOwnSenses + 1;

/// at_home { rest, eat }, out: hungry as time goes by, fed by eating bread.
Brain eater() {
    Brain brain;
    brain.name = "eater";
    brain.decide_every_s = 1.0F;
    brain.variables = {{"hunger", 0.25F, 0.01F, 0.0F, 1.0F}, {"bread", 3.0F, 0.0F, 0.0F, 10.0F}};
    BrainState rest;
    rest.name = "rest";
    rest.changes = {{0, 0.005F, 0.0F}};
    Transition hungry{1, Sensor::kTimeInState, Compare::kAbove, 0.5F, 0.0F, kHunger};
    hungry.also = {{kBread, Compare::kAbove, 0.5F}};
    rest.transitions = {hungry};
    BrainState eat;
    eat.name = "eat";
    eat.changes = {{0, -0.1F, 0.0F}, {1, {}, -1.0F}};
    eat.transitions = {{0, Sensor::kTimeInState, Compare::kBelow, 0.1F, 0.0F, kHunger}};
    BrainState home;
    home.name = "at_home";
    home.inside = {rest, eat};
    home.changes = {{0, 0.02F, 0.0F}};
    home.transitions = {{1, Sensor::kPlayerDistance, Compare::kBelow, 5.0F}};
    BrainState out;
    out.name = "out";
    out.changes = {{1, {}, 5.0F}};
    out.transitions = {{0, Sensor::kPlayerDistance, Compare::kAbove, 5.0F}};
    brain.states = {home, out};
    return brain;
}

class Eater {
  public:
    Eater() : written(eater()), brain(compile(written, 1.0F)) {
        agent.entity = EntityId(1);
        begin(agent, brain, 0);
    }

    std::string decide(Tick now, float player = 100.0F) {
        percept.distance = player;
        ai::decide(agent, brain, percept, Vec2::Zero(), PointsOfInterest(), now, scratch);
        last = now;
        return brain.states[agent.state_machine.leaf].name;
    }

    /// As of the last decision.
    [[nodiscard]] float variable(std::size_t v) const { return variable_at(agent, brain, v, last); }

    Brain written;
    CompiledBrain brain;
    Agent agent;
    Percept percept;
    DecisionScratch scratch;
    Tick last = 0;
};

TEST(Variables, GrowAndAreFedByStates) {
    Eater eater;
    EXPECT_EQ(eater.variable(0), 0.25F);
    EXPECT_EQ(eater.decide(10), "at_home/rest");
    EXPECT_NEAR(eater.variable(0), 0.3F, 1e-6F);  // the inner state's rate: 0.005 a second
    EXPECT_EQ(eater.decide(51), "at_home/eat");   // 0.505
    EXPECT_EQ(eater.variable(1), 2.0F);           // a bread less, at once
    EXPECT_EQ(eater.decide(53), "at_home/eat");
    EXPECT_NEAR(eater.variable(0), 0.305F, 1e-6F);
    EXPECT_EQ(eater.decide(61), "at_home/rest");
    EXPECT_EQ(eater.variable(0), 0.0F);  // never below low
    EXPECT_EQ(eater.decide(62, 1.0F), "out");
    EXPECT_EQ(eater.variable(1), 7.0F);
    // The states out there do not change hunger: the variable's own rate holds.
    EXPECT_EQ(eater.decide(72, 1.0F), "out");
    EXPECT_NEAR(eater.variable(0), 0.005F + 0.1F, 1e-6F);
    EXPECT_EQ(eater.decide(73), "at_home/rest");
    EXPECT_EQ(eater.decide(74, 1.0F), "out");
    EXPECT_EQ(eater.variable(1), 10.0F);  // never above high
}

TEST(Variables, DoNotDependOnHowOftenTheyAreLookedAt) {
    Eater often;
    Eater seldom;
    for (Tick now = 1; now <= 40; ++now) {
        EXPECT_EQ(often.decide(now), "at_home/rest");
    }
    EXPECT_EQ(seldom.decide(40), "at_home/rest");
    EXPECT_EQ(often.variable(0), seldom.variable(0)) << "to the last bit";
}

TEST(Variables, StopAWayThatNeedsWhatIsNotThere) {
    Eater eater;
    eater.agent.variables[1] = 0.0F;
    EXPECT_EQ(eater.decide(100), "at_home/rest");
    EXPECT_GT(eater.variable(0), 0.5F);
}

BrainState action_named(const char* name, ActionKind action) {
    BrainState state;
    state.name = name;
    state.action = action;
    return state;
}

/// Near: fight or flee, by vigour; else at rest, where vigour comes back.
Brain chooser() {
    Brain brain;
    brain.name = "chooser";
    brain.variables = {{"vigour", 1.0F, 0.0F, 0.0F, 1.0F}};
    BrainState alert = action_named("alert", ActionKind::kIdle);
    TreeChoice by_tree;
    by_tree.def.nodes = {{"near", {kSensePlayerDistance, Compare::kBelow, 10.0F}, 1, 2, 0},
                         {"strong", {kOwnSenses, Compare::kAbove, 0.5F}, 3, 4, 0},
                         {"rest", {}, -1, -1, 0},
                         {"fight", {}, -1, -1, 1},
                         {"flee", {}, -1, -1, 2}};
    alert.choice = by_tree;
    alert.actions = {action_named("rest", ActionKind::kReturn),
                     action_named("fight", ActionKind::kChase),
                     action_named("flee", ActionKind::kFlee)};
    alert.actions[0].changes = {{0, 0.1F, 0.0F}};
    alert.actions[1].changes = {{0, -0.2F, -0.1F}};
    brain.states = {alert};
    return brain;
}

TEST(TreeChoice, SaysWhatToDoAtEachDecision) {
    const CompiledBrain brain = compile(chooser(), 1.0F);
    Agent agent;
    agent.entity = EntityId(1);
    begin(agent, brain, 0);
    DecisionScratch scratch;
    const auto current_action = [&](Tick now, float player) {
        Percept percept;
        percept.distance = player;
        agent.entered = false;
        ai::decide(agent, brain, percept, Vec2::Zero(), PointsOfInterest(), now, scratch);
        return brain.states[agent.current_action].name;
    };
    EXPECT_EQ(current_action(0, 50), "alert:rest");
    EXPECT_TRUE(agent.entered) << "a action_named that is new begins";
    EXPECT_EQ(current_action(1, 50), "alert:rest");
    EXPECT_FALSE(agent.entered) << "one that goes on does not";
    EXPECT_EQ(current_action(2, 5), "alert:fight");
    EXPECT_NEAR(agent.variables[0], 0.9F, 1e-6F);
    EXPECT_EQ(current_action(3, 5), "alert:fight");  // 0.7
    EXPECT_EQ(current_action(4, 5), "alert:flee");   // 0.5
    EXPECT_EQ(current_action(9, 5), "alert:flee");
    EXPECT_NEAR(agent.variables[0], 0.5F, 1e-6F);
    EXPECT_EQ(current_action(10, 50), "alert:rest");
    EXPECT_EQ(current_action(11, 5), "alert:fight");  // 0.6
}

/// Wants to be fed: bread is bought with coins, coins are earned.
Brain buyer() {
    Brain brain;
    brain.name = "buyer";
    brain.variables = {{"coins", 0, 0, 0, 10}, {"bread", 0, 0, 0, 10}, {"food", 0, -0.01F, 0, 1}};
    BrainState live = action_named("live", ActionKind::kIdle);
    PlanChoice plan;
    plan.domain.facts = {"has_coins", "has_bread", "fed"};
    plan.domain.actions = {{"earn", {}, {1, 0}, 1},
                           {"buy", {1, 0}, {2, 0}, 1},
                           {"eat", {2, 0}, {4, 0}, 1},
                           {"beg", {}, {4, 0}, 9}};
    plan.domain.goals = {{"fed", {4, 0}}};
    plan.facts = {{{kOwnSenses, Compare::kAbove, 2.5F}},
                  {{kOwnSenses + 1, Compare::kAbove, 0.5F}},
                  {{kOwnSenses + 2, Compare::kAbove, 0.5F}}};
    live.choice = plan;
    live.actions = {action_named("earn", ActionKind::kPatrol),
                    action_named("buy", ActionKind::kReturn),
                    action_named("eat", ActionKind::kIdle),
                    action_named("beg", ActionKind::kFlock)};
    live.actions[0].changes = {{0, 1.0F, 0.0F}};
    live.actions[1].changes = {{0, 0.0F, -3.0F}, {1, 0.0F, 2.0F}};
    live.actions[2].changes = {{1, 0.0F, -1.0F}, {2, 0.5F, 0.0F}};
    brain.states = {live};
    return brain;
}

TEST(PlanChoice, DoesTheFirstStepOfAPlanUntilAFactChanges) {
    const CompiledBrain brain = compile(buyer(), 1.0F);
    Agent agent;
    agent.entity = EntityId(1);
    begin(agent, brain, 0);
    DecisionScratch scratch;
    std::vector<std::string> done;
    for (Tick now = 0; now < 12; ++now) {
        ai::decide(agent, brain, Percept(), Vec2::Zero(), PointsOfInterest(), now, scratch);
        done.push_back(brain.states[agent.current_action].name);
    }
    // Three coins after three seconds; bread at once; eating takes two; then nothing is left to do.
    EXPECT_THAT(done,
                testing::ElementsAre("live:earn",
                                     "live:earn",
                                     "live:earn",
                                     "live:buy",
                                     "live:eat",
                                     "live:eat",
                                     "live",
                                     "live",
                                     "live",
                                     "live",
                                     "live",
                                     "live"));
    EXPECT_EQ(scratch.plans, 4U);
    // Bread is left: hungry again, it only eats.
    agent.variables[2] = 0.0F;
    ai::decide(agent, brain, Percept(), Vec2::Zero(), PointsOfInterest(), 12, scratch);
    EXPECT_EQ(brain.states[agent.current_action].name, "live:eat");
}

TEST(PlanChoice, DoesTheStatesOwnActionWhereThereIsNoPlan) {
    Brain written = buyer();
    auto& plan = std::get<PlanChoice>(written.states[0].choice);
    plan.domain.actions[2].makes = {0, 1};
    plan.domain.actions[3].makes = {0, 1};
    const CompiledBrain brain = compile(written, 1.0F);
    Agent agent;
    agent.entity = EntityId(1);
    begin(agent, brain, 0);
    DecisionScratch scratch;
    for (Tick now = 0; now < 5; ++now) {
        ai::decide(agent, brain, Percept(), Vec2::Zero(), PointsOfInterest(), now, scratch);
        EXPECT_EQ(brain.states[agent.current_action].name, "live");
    }
    EXPECT_EQ(scratch.plans, 1U) << "nothing has changed: it is not tried again";
    EXPECT_EQ(scratch.plans_unreachable, 1U);
}

TEST(PlanChoice, CutsOffASearchThatMeetsItsBound) {
    const CompiledBrain brain = compile(buyer(), 1.0F);
    Agent agent;
    agent.entity = EntityId(1);
    begin(agent, brain, 0);
    DecisionScratch scratch;
    scratch.max_plan_nodes = 1;
    ai::decide(agent, brain, Percept(), Vec2::Zero(), PointsOfInterest(), 0, scratch);
    EXPECT_EQ(scratch.plans_cut_off, 1U);
    EXPECT_EQ(brain.states[agent.current_action].name, "live");
}

TEST(Explain, TellsStatesSensesAndWhatIsWaitedFor) {
    Eater eater;
    eater.decide(10);
    eater.percept.distance = 42.0F;
    const std::string text = explain(eater.agent,
                                     eater.written,
                                     eater.brain,
                                     eater.percept,
                                     Vec2(3.0F, 4.0F),
                                     PointsOfInterest(),
                                     20,
                                     1.0F);
    EXPECT_THAT(text,
                HasSubstr("brain eater, in state:\n  at_home for 20.00 s\n"
                          "  at_home/rest for 20.00 s\n"));
    EXPECT_THAT(text, HasSubstr("  player distance 42\n  home distance 5\n"));
    EXPECT_THAT(text, HasSubstr("  hunger 0.35\n  bread 3\n"));
    EXPECT_THAT(text, HasSubstr("  at_home -> out: player distance 42 below 5: no\n"));
    EXPECT_THAT(text,
                HasSubstr("  at_home/rest -> at_home/eat: hunger 0.35 above 0.5: no, and bread 3 "
                          "above 0.5: yes\n"));
    EXPECT_EQ(eater.agent.variables_at, 0) << "to ask changes nothing";
}

TEST(Explain, TellsWhichRulesFireAndWhatIsHeld) {
    Brain brain;
    brain.name = "m";
    brain.fuzzy.emplace_back();
    fuzzy::FuzzyDef& def = brain.fuzzy[0].def;
    const float infinity = std::numeric_limits<float>::infinity();
    def.name = "fear";
    def.inputs = {
        {"distance", 0, 10, {{"near", -infinity, 0, 0, 10}, {"far", 0, 10, 10, infinity}}}};
    fuzzy::FuzzyOutput much;
    much.name = "much";
    much.values = {{"none", 0, {}}, {"all", 1, {}}};
    def.outputs = {much};
    def.rules = {{{{0, 0, false}}, false, 0, 1, 1}, {{{0, 1, false}}, false, 0, 0, 1}};
    brain.fuzzy[0].inputs = {kSensePlayerDistance};
    brain.states.resize(2);
    brain.states[0].name = "calm";
    brain.states[1].name = "afraid";
    brain.states[0].transitions = {{1, Sensor::kRandom, Compare::kAbove, 0.5F, 2.0F, kOwnSenses}};
    const CompiledBrain compiled = compile(brain, 0.5F);
    Agent agent;
    agent.entity = EntityId(1);
    begin(agent, compiled, 0);
    DecisionScratch scratch;
    Percept percept;
    percept.distance = 2.5F;
    EXPECT_FALSE(
        ai::decide(agent, compiled, percept, Vec2::Zero(), PointsOfInterest(), 0, scratch));
    const std::string text =
        explain(agent, brain, compiled, percept, Vec2::Zero(), PointsOfInterest(), 2, 0.5F);
    EXPECT_THAT(text, HasSubstr("  distance is near, then much is all: 0.75\n"));
    EXPECT_THAT(text, HasSubstr("  distance is far, then much is none: 0.25\n"));
    EXPECT_THAT(text, HasSubstr("fear.much 0.75 above 0.5: yes, held 1.00 of 2.00 s\n"));
    EXPECT_TRUE(ai::decide(agent, compiled, percept, Vec2::Zero(), PointsOfInterest(), 4, scratch));
}

}  // namespace
}  // namespace zoned::ai::test
