#include "server/ai/decision/state_machine/flat_state_machine.h"
#include "tests/scenario/sentry.h"
#include "tests/scenario/villager.h"
#include "tests/scenario/walked_state_machine.h"

#include <gmock/gmock.h>

namespace zoned::ai::state_machine::test {
namespace {

using scenario::Sensed;
using scenario::villager_def;

/// One villager; each tick is a second. Senses: alarm, foe distance, hunger, load.
class Villager {
  public:
    explicit Villager(StateHistory labour = StateHistory::kNone,
                      StateHistory day = StateHistory::kNone)
        : machine(compile(villager_def(labour, day), scenario::kVillagerSenses, 1.0F)) {}

    std::string tick(float alarm, float foe, float hunger, float load) {
        const float values[] = {alarm, foe, hunger, load};
        step(machine, state, values, now++);
        return machine.state_name(state.leaf);
    }

    FlatStateMachine machine;
    ActiveState state;
    Tick now = 0;
};

TEST(HierarchicalFsm, BeginsAtTheFirstOfTheFirst) {
    Villager villager;
    EXPECT_EQ(villager.machine.levels, 3U);
    EXPECT_EQ(villager.tick(0, 50, 0, 0), "day/labour/fetch");
}

TEST(HierarchicalFsm, FollowsATraceComputedByHand) {
    Villager villager;
    EXPECT_EQ(villager.tick(0, 50, 0, 0.5F), "day/labour/fetch");
    EXPECT_EQ(villager.tick(0, 50, 0, 0.9F), "day/labour/carry");
    EXPECT_EQ(villager.tick(0, 50, 0.8F, 0.9F), "day/eat");           // out of labour
    EXPECT_EQ(villager.tick(0, 50, 0.1F, 0.9F), "day/labour/fetch");  // no memory: from the first
    EXPECT_EQ(villager.tick(1, 50, 0.1F, 0.9F), "danger/flee");       // out of day
    EXPECT_EQ(villager.tick(1, 4, 0.1F, 0.9F), "danger/fight/close_in");
    EXPECT_EQ(villager.tick(1, 1, 0.1F, 0.9F), "danger/fight/strike");
    EXPECT_EQ(villager.tick(1, 9, 0.1F, 0.9F), "danger/flee");
    EXPECT_EQ(villager.tick(0, 9, 0.1F, 0.9F), "day/labour/fetch");
}

TEST(HierarchicalFsm, HearsTheOutermostStateFirst) {
    Villager villager;
    villager.tick(0, 50, 0, 0);
    // Hungry, loaded and alarmed in one tick: labour would go on to carry, day to eat.
    EXPECT_EQ(villager.tick(1, 50, 0.9F, 0.9F), "danger/flee");
}

TEST(HierarchicalFsm, ComesBackToTheLastStateWithShallowHistory) {
    Villager villager(StateHistory::kNone, StateHistory::kShallow);
    villager.tick(0, 50, 0.8F, 0);
    EXPECT_EQ(villager.tick(0, 50, 0.8F, 0), "day/eat");
    villager.tick(1, 50, 0.8F, 0);
    EXPECT_EQ(villager.tick(0, 50, 0.8F, 0), "day/eat");
}

TEST(HierarchicalFsm, BeginsAnewBelowAShallowHistory) {
    Villager villager(StateHistory::kNone, StateHistory::kShallow);
    EXPECT_EQ(villager.tick(0, 50, 0, 0.9F), "day/labour/carry");
    villager.tick(1, 50, 0, 0.9F);
    EXPECT_EQ(villager.tick(0, 50, 0, 0.5F), "day/labour/fetch");
}

TEST(HierarchicalFsm, ComesBackAllTheWayDownWithDeepHistory) {
    Villager villager(StateHistory::kNone, StateHistory::kDeep);
    EXPECT_EQ(villager.tick(0, 50, 0, 0.9F), "day/labour/carry");
    villager.tick(1, 50, 0, 0.9F);
    EXPECT_EQ(villager.tick(0, 50, 0, 0.5F), "day/labour/carry");
}

TEST(HierarchicalFsm, RemembersInsideOfWhatItEntersAnew) {
    // Labour remembers, day does not: out of day and back, day begins with labour, and labour where
    // it was.
    Villager villager(StateHistory::kShallow, StateHistory::kNone);
    EXPECT_EQ(villager.tick(0, 50, 0, 0.9F), "day/labour/carry");
    villager.tick(1, 50, 0, 0.9F);
    EXPECT_EQ(villager.tick(0, 50, 0, 0.5F), "day/labour/carry");
}

TEST(HierarchicalFsm, KeepsTheTimeOfEachLevel) {
    Villager villager;
    villager.tick(0, 50, 0, 0);     // tick 0
    villager.tick(0, 50, 0, 0.9F);  // tick 1: carry
    EXPECT_EQ(villager.state.since[0], 0);
    EXPECT_EQ(villager.state.since[1], 0);
    EXPECT_EQ(villager.state.since[2], 1);
    villager.tick(0, 50, 0.8F, 0);  // tick 2: eat
    EXPECT_EQ(villager.state.since[0], 0);
    EXPECT_EQ(villager.state.since[1], 2);
}

TEST(HierarchicalFsm, KeepsAnOuterHoldThroughInnerTransitions) {
    // The outer transition must hold 4 s; meanwhile the inner state changes each second.
    StateDef a{"a", 0, {{1, {{1, Compare::kBelow, 0.5F}}, 0}}, {}, {}};
    StateDef b{"b", 0, {{0, {{1, Compare::kAbove, 0.5F}}, 0}}, {}, {}};
    StateDef outer{"outer", 0, {{1, {{0, Compare::kAbove, 0.0F}}, 4}}, {a, b}, {}};
    StateDef end{"end", 0, {}, {}, {}};
    const FlatStateMachine machine = compile({"m", {outer, end}}, 2, 1.0F);
    ActiveState state;
    std::vector<std::string> trace;
    for (Tick now = 0; now < 5; ++now) {
        const float values[] = {1.0F, now % 2 == 0 ? 0.0F : 1.0F};
        step(machine, state, values, now);
        trace.push_back(machine.state_name(state.leaf));
    }
    EXPECT_THAT(trace, testing::ElementsAre("outer/b", "outer/a", "outer/b", "outer/a", "end"));
}

TEST(HierarchicalFsm, DropsAnInnerHoldWithItsState) {
    StateDef a{"a", 0, {{1, {{0, Compare::kAbove, 0.0F}}, 2}}, {}, {}};
    StateDef b{"b", 0, {}, {}, {}};
    StateDef outer{"outer", 0, {{0, {{1, Compare::kAbove, 0.0F}}, 0}}, {a, b}, {}};
    const FlatStateMachine machine = compile({"m", {outer}}, 2, 1.0F);
    ActiveState state;
    const float holding[] = {1.0F, 0.0F};
    const float leaving[] = {1.0F, 1.0F};
    step(machine, state, holding, 0);  // holds since 0
    step(machine, state, leaving, 1);  // outer is entered anew
    EXPECT_EQ(state.pending, kNone);
    step(machine, state, holding, 2);
    step(machine, state, holding, 3);
    EXPECT_EQ(machine.state_name(state.leaf), "outer/a");
    step(machine, state, holding, 4);
    EXPECT_EQ(machine.state_name(state.leaf), "outer/b");
}

TEST(HierarchicalFsm, AgreesWithAWalkThroughTheDefinition) {
    constexpr std::size_t kCount = 300;
    for (const StateHistory labour :
         {StateHistory::kNone, StateHistory::kShallow, StateHistory::kDeep}) {
        for (const StateHistory day :
             {StateHistory::kNone, StateHistory::kShallow, StateHistory::kDeep}) {
            const StateMachineDef def = villager_def(labour, day);
            const FlatStateMachine machine = compile(def, scenario::kVillagerSenses, 1.0F);
            std::vector<ActiveState> states(kCount);
            std::vector<scenario::WalkedMachine> walked(kCount, scenario::WalkedMachine(def, 1.0F));
            Sensed sensed(scenario::kVillagerSenses, kCount);
            std::size_t changes = 0;
            core::Rng rng(3);
            for (Tick now = 0; now < 400; ++now) {
                scenario::villager_walk(sensed, kCount, rng);
                for (std::size_t i = 0; i < kCount; ++i) {
                    changes += step(machine, states[i], sensed.of(i), now) ? 1U : 0U;
                    walked[i].tick(now, sensed.of(i));
                    ASSERT_EQ(machine.state_name(states[i].leaf), walked[i].name())
                        << "agent " << i << " tick " << now;
                }
            }
            EXPECT_GT(changes, 20 * kCount);
        }
    }
}

TEST(FsmStep, AgreesWithAWalkThroughTheDefinitionWithHoldsToo) {
    constexpr std::size_t kCount = 300;
    const StateMachineDef def = scenario::sentry_def();
    const FlatStateMachine machine = compile(def, scenario::kSentrySenses, scenario::kSentryDt);
    std::vector<ActiveState> states(kCount);
    std::vector<scenario::WalkedMachine> walked(kCount,
                                                scenario::WalkedMachine(def, scenario::kSentryDt));
    Sensed sensed(scenario::kSentrySenses, kCount);
    std::size_t changes = 0;
    core::Rng rng(9);
    for (Tick now = 0; now < 1000; ++now) {
        scenario::sentry_walk(sensed, kCount, rng);
        for (std::size_t i = 0; i < kCount; ++i) {
            changes += step(machine, states[i], sensed.of(i), now) ? 1U : 0U;
            walked[i].tick(now, sensed.of(i));
            ASSERT_EQ(machine.state_name(states[i].leaf), walked[i].name())
                << "agent " << i << " tick " << now;
        }
    }
    EXPECT_GT(changes, 5 * kCount);
}

}  // namespace
}  // namespace zoned::ai::state_machine::test
