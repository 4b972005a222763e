// HotReloadMigration: states with a name in both brains stay, all others start anew.
#include "server/ai/agent/hot_reload_migration.h"

#include "server/ai/agent/decision.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <limits>

namespace zoned::ai::test {
namespace {

BrainState named(const std::string& name, ActionKind action) {
    BrainState state;
    state.name = name;
    state.action = action;
    return state;
}

/// "day" holds "walk" and "stand" with a deep history; "alarm" is beside it.
Brain layered() {
    Brain brain;
    brain.name = "layered";
    brain.variables = {{"hunger", 0.2F, 0.1F}, {"coins", 1.0F, 0.0F, 0.0F, 10.0F}};
    BrainState day = named("day", ActionKind::kIdle);
    day.history = state_machine::StateHistory::kDeep;
    day.inside = {named("walk", ActionKind::kPatrol), named("stand", ActionKind::kIdle)};
    day.inside[0].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 1.0F}};
    day.inside[1].transitions = {{0, Sensor::kTimeInState, Compare::kAbove, 9.0F}};
    day.transitions = {{1, Sensor::kPlayerDistance, Compare::kBelow, 10.0F}};
    BrainState alarm = named("alarm", ActionKind::kChase);
    alarm.transitions = {{0, Sensor::kPlayerDistance, Compare::kAbove, 20.0F}};
    brain.states = {day, alarm};
    return brain;
}

struct ReloadLife {
    CompiledBrain brain;
    Agent agent;
    DecisionScratch scratch;
    Tick now = 0;

    explicit ReloadLife(const Brain& of) : brain(compile(of, kDt)) {
        agent.entity = EntityId(1);
        begin(agent, brain, 0);
    }

    std::string after(Tick ticks, float player_m) {
        now += ticks;
        Percept percept;
        percept.distance = player_m;
        ai::decide(agent, brain, percept, Vec2::Zero(), PointsOfInterest(), now, scratch);
        return brain.states[agent.current_action].name;
    }

    void become(const Brain& other, std::uint16_t index = 0) {
        const CompiledBrain compiled = compile(other, kDt);
        migrate(agent, brain, compiled, index, now, kDt);
        brain = compiled;
    }
};

constexpr float kNobody = std::numeric_limits<float>::infinity();

TEST(HotReloadMigration, TheSameBrainChangesNothingThatShows) {
    ReloadLife life(layered());
    ReloadLife other(layered());
    life.after(40, kNobody);
    other.after(40, kNobody);
    life.agent.entered = other.agent.entered = false;  // both have begun to act
    life.become(layered());
    EXPECT_EQ(life.agent.state_machine.leaf, other.agent.state_machine.leaf);
    EXPECT_EQ(life.agent.state_machine.since, other.agent.state_machine.since);
    EXPECT_FALSE(life.agent.entered);
    for (const Tick step : {10, 200, 90, 60}) {
        const float player = step == 90 ? 5.0F : 30.0F;
        EXPECT_EQ(life.after(step, player), other.after(step, player));
        EXPECT_NEAR(life.agent.variables[0], other.agent.variables[0], 1e-5F);
    }
}

TEST(HotReloadMigration, KeepsStatesTimesHistoriesAndVariablesByName) {
    ReloadLife life(layered());
    EXPECT_EQ(life.after(31, kNobody), "day/stand");
    EXPECT_EQ(life.after(3, 5.0F), "alarm");
    Brain other = layered();
    // Another order, one state more, another threshold, and hunger beside something new.
    other.states[0].inside.insert(other.states[0].inside.begin(),
                                  named("sleep", ActionKind::kIdle));
    other.states[0].inside[0].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 5.0F}};
    other.states[0].inside[1].transitions = {{2, Sensor::kTimeInState, Compare::kAbove, 1.0F},
                                             {0, Sensor::kRandom, Compare::kAbove, 2.0F}};
    other.states[0].inside[2].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 9.0F}};
    other.variables = {{"mood", 0.7F}, {"hunger", 0.0F, 0.0F, 0.0F, 0.25F}};
    life.become(other, 3);
    EXPECT_EQ(life.agent.brain, 3);
    EXPECT_EQ(life.brain.states[life.agent.current_action].name, "alarm");
    EXPECT_EQ(life.agent.state_machine.since[0], 34);
    EXPECT_EQ(life.agent.variables[0], 0.7F);
    // 0.2 and 34 ticks at 0.1 a second are 0.313, beyond the new bound.
    EXPECT_EQ(life.agent.variables[1], 0.25F);
    EXPECT_EQ(life.after(1, kNobody), "day/stand") << "where it had been when the alarm came";
}

TEST(HotReloadMigration, BeginsAnewWhereTheStateIsNoMore) {
    ReloadLife life(layered());
    EXPECT_EQ(life.after(3, 5.0F), "alarm");
    Brain other = layered();
    other.states[1].name = "panic";
    other.states[0].inside[0].changes = {{1, std::nullopt, 2.0F}};
    life.become(other);
    EXPECT_EQ(life.brain.states[life.agent.current_action].name, "day/walk");
    EXPECT_EQ(life.agent.state_machine.since[0], life.now);
    EXPECT_TRUE(life.agent.entered);
    EXPECT_EQ(life.agent.variables[1], 3.0F) << "one coin, and two for entering";
}

TEST(HotReloadMigration, StartsAnActionAgainWhereItBecameAnother) {
    ReloadLife life(layered());
    life.after(3, 5.0F);
    life.agent.entered = false;
    Brain other = layered();
    other.states[1].action = ActionKind::kFlee;
    life.become(other);
    EXPECT_EQ(life.brain.states[life.agent.current_action].name, "alarm");
    EXPECT_TRUE(life.agent.entered);
}

}  // namespace
}  // namespace zoned::ai::test
