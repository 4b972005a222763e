#include "server/ai/decision/state_machine/flat_state_machine.h"
#include "server/ai/decision/state_machine/state_flapping.h"
#include "tests/scenario/sentry.h"
#include "tests/unit/allocation_count.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <set>

namespace zoned::ai::state_machine::test {
namespace {

using scenario::Sensed;
using scenario::SentryState;
using testing::ElementsAre;

/// Runs a state machine of one agent by hand.
class Lone {
  public:
    explicit Lone(const StateMachineDef& def, std::size_t senses, float dt = 1.0F)
        : machine(compile(def, senses, dt)),
          values_(senses) {}

    /// The name of the state after the decision of the next tick.
    std::string tick(std::initializer_list<float> values) {
        std::copy(values.begin(), values.end(), values_.begin());
        change = step(machine, state, values_, now++);
        return machine.state_name(state.leaf);
    }

    FlatStateMachine machine;
    ActiveState state;
    Tick now = 0;
    std::optional<StateChange> change;

  private:
    std::vector<float> values_;  // those that a tick leaves out stay
};

TransitionDef go(std::uint16_t to, std::vector<Condition> when, float hold_s = 0.0F) {
    return {to, std::move(when), hold_s};
}

Condition below(SenseIndex sense, float threshold) {
    return {sense, Compare::kBelow, threshold};
}

Condition above(SenseIndex sense, float threshold) {
    return {sense, Compare::kAbove, threshold};
}

StateDef leaf(const char* name, std::vector<TransitionDef> transitions = {}) {
    return {name, 0, std::move(transitions), {}, {}};
}

TEST(FsmStep, FollowsATraceComputedByHand) {
    Lone agent(scenario::sentry_def(), scenario::kSentrySenses, scenario::kSentryDt);
    // Foe, post, health, noise. Nine ticks of a foe within 20 m make a chase: it holds from tick 1
    // on, so that it fires in tick 10.
    EXPECT_EQ(agent.tick({50, 0, 1, 0}), "patrol");
    for (int tick = 1; tick <= 9; ++tick) {
        EXPECT_EQ(agent.tick({15, 0, 1, 0}), "patrol") << tick;
    }
    EXPECT_EQ(agent.tick({15, 0, 1, 0}), "chase");
    EXPECT_EQ(agent.tick({2, 0, 1, 0}), "fight");
    EXPECT_EQ(agent.tick({2, 0, 0.2F, 0}), "flee");
    EXPECT_EQ(agent.tick({41, 0, 0.2F, 0}), "rest");
    EXPECT_EQ(agent.tick({41, 0, 0.95F, 0}), "patrol");
    EXPECT_EQ(agent.tick({41, 0, 0.95F, 0.9F}), "listen");
    // Entered in tick 15; 150 ticks of 1/30 s are, in floats, a hair above 5 s.
    for (int tick = 16; tick < 165; ++tick) {
        EXPECT_EQ(agent.tick({41, 0, 0.95F, 0}), "listen") << tick;
    }
    EXPECT_EQ(agent.tick({41, 0, 0.95F, 0}), "patrol");
    ASSERT_TRUE(agent.change.has_value());
    EXPECT_EQ(agent.change->transition, 3);
}

TEST(FsmStep, ForgetsAHoldThatWasInterrupted) {
    Lone agent({"m", {leaf("a", {go(1, {below(0, 5)}, 3)}), leaf("b")}}, 1);
    agent.tick({1});
    agent.tick({1});
    agent.tick({9});
    agent.tick({1});
    agent.tick({1});
    EXPECT_EQ(agent.tick({1}), "a");
    EXPECT_EQ(agent.tick({1}), "b");
}

TEST(FsmStep, TakesWhatFiresAtOnceWhileAnotherIsHeld) {
    Lone agent(
        {"m", {leaf("a", {go(1, {below(0, 5)}, 100), go(2, {above(1, 0)})}), leaf("b"), leaf("c")}},
        2);
    EXPECT_EQ(agent.tick({1, 0}), "a");
    EXPECT_EQ(agent.tick({1, 1}), "c");
}

TEST(FsmStep, WantsAllConditionsOfATransition) {
    Lone agent({"m", {leaf("a", {go(1, {below(0, 5), above(1, 2), below(2, 1)})}), leaf("b")}}, 3);
    EXPECT_EQ(agent.tick({1, 3, 1}), "a");
    EXPECT_EQ(agent.tick({1, 2, 0}), "a");
    EXPECT_EQ(agent.tick({5, 3, 0}), "a");
    EXPECT_EQ(agent.tick({1, 3, 0}), "b");
}

TEST(FsmStep, NeverHoldsForWhatIsNoNumber) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    Lone agent({"m", {leaf("a", {go(1, {below(0, 5)}), go(1, {above(0, 5)})}), leaf("b")}}, 1);
    EXPECT_EQ(agent.tick({nan}), "a");
    EXPECT_EQ(agent.tick({infinity}), "b");
}

TEST(FsmStep, NeverTakesAPlaceThatIsNotUsedWhateverItSenses) {
    // One transition in a table of two: the filler entry reads sense 0 and must not hold.
    Lone agent({"m", {leaf("a", {go(1, {below(1, -5)})}), leaf("b")}}, 2);
    for (const float value : {-std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::lowest(),
                              std::numeric_limits<float>::quiet_NaN()}) {
        EXPECT_EQ(agent.tick({value, 0}), "a");
    }
}

TEST(HoldTicks, AreTheFewestThatLastAsLongAsAsked) {
    for (const float dt : {1.0F / 30.0F, 1.0F / 60.0F, 0.05F, 1.0F}) {
        for (const float hold : {0.001F, 0.1F, 0.2F, 0.3F, 0.5F, 1.0F, 7.77F, 600.0F}) {
            const Tick ticks = hold_ticks(hold, dt);
            EXPECT_GE(static_cast<float>(ticks) * dt, hold);
            EXPECT_TRUE(ticks == 1 || static_cast<float>(ticks - 1) * dt < hold);
        }
    }
    EXPECT_EQ(hold_ticks(0.0F, 0.1F), 0);
    EXPECT_EQ(hold_ticks(0.3F, scenario::kSentryDt), 9);
    EXPECT_EQ(hold_ticks(1.0F, scenario::kSentryDt), 30);
}

/// The three forms of the sentry side by side.
class Forms {
  public:
    explicit Forms(std::size_t count)
        : machine(compile(scenario::sentry_def(), scenario::kSentrySenses, scenario::kSentryDt)),
          switched(scenario::bound_sentry(false, machine)),
          classed(scenario::bound_sentry(true, machine)),
          tables(count),
          by_switch(count),
          by_class(count),
          sensed(scenario::kSentrySenses, count) {}

    /// The number of agents of which the forms differ after this tick; `taken`: their transitions.
    std::size_t tick(Tick now, std::set<std::uint16_t>& taken) {
        std::size_t differ = 0;
        for (std::size_t i = 0; i < tables.size(); ++i) {
            const std::optional<StateChange> change = step(machine, tables[i], sensed.of(i), now);
            differ += same(change, switched.decide(by_switch[i], sensed.of(i), now)) &&
                              same(change, classed.decide(by_class[i], sensed.of(i), now)) &&
                              same(tables[i], by_switch[i]) && same(tables[i], by_class[i])
                          ? 0U
                          : 1U;
            if (change) {
                taken.insert(change->transition);
            }
        }
        return differ;
    }

    FlatStateMachine machine;
    BoundMachine switched;
    BoundMachine classed;
    std::vector<ActiveState> tables;
    std::vector<ActiveState> by_switch;
    std::vector<ActiveState> by_class;
    Sensed sensed;

  private:
    static bool same(const std::optional<StateChange>& a, const std::optional<StateChange>& b) {
        return a.has_value() == b.has_value() &&
               (!a || (a->from == b->from && a->to == b->to && a->transition == b->transition));
    }

    static bool same(const ActiveState& a, const ActiveState& b) {
        return a.leaf == b.leaf && a.pending == b.pending && a.since[0] == b.since[0] &&
               (a.pending == kNone || a.pending_since == b.pending_since);
    }
};

TEST(FsmForms, AgreeInEveryTickOfEveryAgent) {
    constexpr std::size_t kCount = 1000;
    Forms forms(kCount);
    core::Rng rng(11);
    std::set<std::uint16_t> taken;
    for (Tick now = 0; now < 1500; ++now) {
        scenario::sentry_walk(forms.sensed, kCount, rng);
        ASSERT_EQ(forms.tick(now, taken), 0U) << now;
    }
    EXPECT_EQ(taken.size(), 12U) << "the walk leads through all transitions";
}

TEST(FsmForms, WouldDifferIfOneThresholdDid) {
    constexpr std::size_t kCount = 200;
    Forms forms(kCount);
    StateMachineDef def = scenario::sentry_def();
    def.states[scenario::kChase].transitions[0].when[0].threshold += 0.01F;
    forms.machine = compile(def, scenario::kSentrySenses, scenario::kSentryDt);
    core::Rng rng(11);
    std::set<std::uint16_t> taken;
    std::size_t differ = 0;
    for (Tick now = 0; now < 1500 && differ == 0; ++now) {
        scenario::sentry_walk(forms.sensed, kCount, rng);
        differ = forms.tick(now, taken);
    }
    EXPECT_GT(differ, 0U);
}

TEST(FsmStep, AllocatesNothing) {
    constexpr std::size_t kCount = 1000;
    Forms forms(kCount);
    core::Rng rng(5);
    std::uint64_t changes = 0;
    const std::uint64_t before = allocation_count();
    for (Tick now = 0; now < 200; ++now) {
        scenario::sentry_walk(forms.sensed, kCount, rng);
        for (std::size_t i = 0; i < kCount; ++i) {
            changes += step(forms.machine, forms.tables[i], forms.sensed.of(i), now) ? 1U : 0U;
            changes += forms.switched.decide(forms.by_switch[i], forms.sensed.of(i), now) ? 1U : 0U;
            changes += forms.classed.decide(forms.by_class[i], forms.sensed.of(i), now) ? 1U : 0U;
        }
    }
    EXPECT_EQ(allocation_count(), before);
    EXPECT_GT(changes, kCount);
}

// ---------------------------------------------------------------- state flapping

TEST(FlappingDetector, NameThePairOfTransitions) {
    Lone agent({"m", {leaf("a", {go(1, {below(0, 5)})}), leaf("b", {go(0, {above(0, 5)})})}}, 1);
    FlappingDetector oscillations({4, 6});
    FlappingDetector::Trace trace;
    for (int tick = 0; tick < 12; ++tick) {
        agent.tick({tick % 2 == 0 ? 1.0F : 9.0F});
        if (agent.change) {
            oscillations.watch(trace, *agent.change, tick);
        }
    }
    ASSERT_EQ(oscillations.found().size(), 1U);
    const FlappingPair& found = oscillations.found()[0];
    EXPECT_EQ(found.a, 0);
    EXPECT_EQ(found.b, 1);
    EXPECT_EQ(found.a_to_b, 0);
    EXPECT_EQ(found.b_to_a, 1);
    EXPECT_EQ(found.count, 2U);  // twelve changes, six each
}

TEST(FlappingDetector, AreNotSeenInSlowChanges) {
    Lone agent({"m", {leaf("a", {go(1, {below(0, 5)})}), leaf("b", {go(0, {above(0, 5)})})}}, 1);
    FlappingDetector oscillations({4, 3});
    FlappingDetector::Trace trace;
    for (int tick = 0; tick < 100; ++tick) {
        agent.tick({tick / 5 % 2 == 0 ? 1.0F : 9.0F});
        if (agent.change) {
            oscillations.watch(trace, *agent.change, tick);
        }
    }
    EXPECT_TRUE(oscillations.found().empty());
}

TEST(FlappingDetector, AreNotSeenInARound) {
    Lone agent({"m",
                {leaf("a", {go(1, {above(0, -1)})}),
                 leaf("b", {go(2, {above(0, -1)})}),
                 leaf("c", {go(0, {above(0, -1)})})}},
               1);
    FlappingDetector oscillations({4, 3});
    FlappingDetector::Trace trace;
    for (int tick = 0; tick < 100; ++tick) {
        agent.tick({0});
        if (agent.change) {
            oscillations.watch(trace, *agent.change, tick);
        }
    }
    EXPECT_TRUE(oscillations.found().empty());
}

// ---------------------------------------------------------------- definitions

std::vector<StateMachineDefectKind> kinds(const StateMachineDef& def, std::size_t senses) {
    std::vector<StateMachineDefectKind> kinds;
    for (const StateMachineDefect& defect : defects_of(def, senses)) {
        kinds.push_back(defect.kind);
    }
    return kinds;
}

TEST(FsmDefects, AreNoneInAStateMachineThatRuns) {
    EXPECT_TRUE(defects_of(scenario::sentry_def(), scenario::kSentrySenses).empty());
}

TEST(FsmDefects, NameTheStateThatNobodyEnters) {
    const auto defects =
        defects_of({"m", {leaf("a"), leaf("b", {go(2, {below(0, 1)})}), leaf("c")}}, 1);
    ASSERT_EQ(defects.size(), 2U);  // c is entered from b alone
    EXPECT_EQ(defects[0].kind, StateMachineDefectKind::kUnreachable);
    EXPECT_THAT(defects[0].state, ElementsAre(1));
    EXPECT_THAT(defects[1].state, ElementsAre(2));
}

TEST(FsmDefects, AreEachFound) {
    EXPECT_THAT(kinds({"m", {}}, 1), ElementsAre(StateMachineDefectKind::kNoStates));
    EXPECT_THAT(kinds({"m", {leaf("a", {go(7, {below(0, 1)})})}}, 1),
                ElementsAre(StateMachineDefectKind::kUnknownState));
    EXPECT_THAT(kinds({"m", {leaf("a", {go(0, {below(3, 1)})})}}, 1),
                ElementsAre(StateMachineDefectKind::kUnknownSense));
    EXPECT_THAT(kinds({"m", {leaf("a", {go(0, {})})}}, 1),
                ElementsAre(StateMachineDefectKind::kNoCondition));
    EXPECT_THAT(kinds({"m", {leaf("a", {go(0, {below(0, 1), above(0, 2)})})}}, 1),
                ElementsAre(StateMachineDefectKind::kNeverHolds));
    EXPECT_THAT(kinds({"m", {leaf("a", {go(0, {below(0, 2)}), go(0, {below(0, 1)})})}}, 1),
                ElementsAre(StateMachineDefectKind::kNeverTried));
    EXPECT_THAT(kinds({"m", {leaf("a", {go(0, {below(0, 1)}), go(0, {below(0, 2)})})}}, 1),
                testing::IsEmpty());
    StateDef remembers = leaf("a");
    remembers.history = StateHistory::kDeep;
    EXPECT_THAT(kinds({"m", {remembers}}, 1), ElementsAre(StateMachineDefectKind::kIdleMemory));
}

TEST(FsmDefects, BoundDepthAndNumber) {
    StateDef nest = leaf("inmost");
    for (std::size_t level = 0; level < kMaxLevels; ++level) {
        StateDef outer = leaf("outer");
        outer.inside = {nest};
        nest = outer;
    }
    EXPECT_THAT(kinds({"m", {nest}}, 1), ElementsAre(StateMachineDefectKind::kTooDeep));
    StateDef busy = leaf("busy");
    for (std::size_t t = 0; t <= kMaxTransitions; ++t) {
        busy.transitions.push_back(go(0, {below(0, static_cast<float>(t))}));
    }
    EXPECT_THAT(kinds({"m", {busy}}, 1), ElementsAre(StateMachineDefectKind::kTooMany));
}

}  // namespace
}  // namespace zoned::ai::state_machine::test
