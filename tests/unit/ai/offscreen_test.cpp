// build: computes
// Off-screen agents: they go from event to event, and resume as if they had been simulated.
#include "server/ai/agent/agent_fields.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <cstring>
#include <tuple>

namespace zoned::ai {
namespace {

using namespace test;

/// A state that was entered.
struct Entered {
    Tick tick;
    std::uint16_t state;

    friend bool operator==(const Entered&, const Entered&) = default;
};

std::ostream& operator<<(std::ostream& out, const Entered& entered) {
    return out << "state " << entered.state << " at tick " << entered.tick;
}

/// The history of one agent.
using Life = std::vector<Entered>;

/// All agents of a field, and their histories.
class Lives {
  public:
    explicit Lives(Brain brain, bool simulated, std::uint32_t count = 20) : count_(count) {
        field.settings.brains = {std::move(brain)};
        field.settings.viewer_range_m = simulated ? std::numeric_limits<float>::infinity() : 50.0F;
        field.wall = nullptr;
        compile(field.settings, kDt);
        for (std::uint32_t id = 1; id <= count; ++id) {
            field.add_npc(id, kGuard, 0, Vec3(10.0F * static_cast<float>(id), 0.9F, 0.0F));
            field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
            begin(*field.agents.find(EntityId(id)), field.settings.compiled[0], 0);
        }
        lives.resize(count);
    }

    void run(float seconds) {
        const Tick end = field.now + static_cast<Tick>(seconds / kDt);
        while (field.now < end) {
            events += field.step().events;
            active += field.agents.active().size();
            for (std::uint32_t id = 1; id <= count_; ++id) {
                const std::uint16_t state = field.state(id);
                Life& life = lives[id - 1];
                if (life.empty() || life.back().state != state) {
                    life.push_back({field.now, state});
                }
            }
        }
    }

    [[nodiscard]] float variable(std::uint32_t id, std::size_t v) const {
        return variable_at(
            *field.agents.find(EntityId(id)), field.settings.compiled[0], v, field.now);
    }

    Field field;
    std::vector<Life> lives;
    std::uint64_t events = 0;
    std::uint64_t active = 0;

  private:
    std::uint32_t count_;
};

Transition on_variable(std::uint16_t to, std::size_t v, Compare compare, float threshold) {
    Transition t;
    t.to = to;
    t.sense = static_cast<SenseIndex>(kOwnSenses + v);
    t.compare = compare;
    t.threshold = threshold;
    return t;
}

/// Gets hungry, eats, sleeps. Now and then it yawns, which only its seed can predict.
Brain drowsy() {
    Brain m;
    m.name = "drowsy";
    m.decide_every_s = 0.2F;
    m.variables = {{"hunger", 0.3F, 0.013F, 0.0F, 1.0F}, {"tired", 0.0F, 0.004F, 0.0F, 1.0F}};
    m.states.resize(4);
    m.states[0].name = "idle";
    m.states[0].transitions = {on_variable(1, 0, Compare::kAbove, 0.7F),
                               on_variable(2, 1, Compare::kAbove, 0.9F),
                               {3, Sensor::kRandom, Compare::kBelow, 0.01F, 0.0F}};
    m.states[0].transitions[0].hold_s = 1.3F;
    m.states[1].name = "eat";
    m.states[1].changes = {{0, -0.11F, -0.05F}};
    m.states[1].transitions = {on_variable(0, 0, Compare::kBelow, 0.11F)};
    m.states[2].name = "sleep";
    m.states[2].changes = {{1, -0.05F, 0.0F}, {0, 0.001F, 0.0F}};
    m.states[2].transitions = {on_variable(0, 1, Compare::kBelow, 0.02F)};
    m.states[3].name = "yawn";
    m.states[3].transitions = {{0, Sensor::kTimeInState, Compare::kAbove, 2.5F, 0.0F}};
    return m;
}

TEST(Offscreen, WhatDependsOnTimeAndVariablesIsTheSameToTheLastBit) {
    Lives all(drowsy(), true);
    Lives some(drowsy(), false);
    all.run(600.0F);
    some.run(600.0F);
    std::size_t entered = 0;
    for (std::uint32_t id = 1; id <= 20; ++id) {
        EXPECT_EQ(all.lives[id - 1], some.lives[id - 1]) << id;
        EXPECT_EQ(all.variable(id, 0), some.variable(id, 0)) << id;
        EXPECT_EQ(all.variable(id, 1), some.variable(id, 1)) << id;
        entered += some.lives[id - 1].size();
    }
    EXPECT_GT(entered, 20U * 30U) << "they did something";
    // Two seconds active, then events alone: some for each state that was entered, and a look ahead
    // at random numbers each 64 decisions (12.8 s).
    EXPECT_LT(some.active, 20U * 100U);
    EXPECT_LT(some.events, 4U * entered + 20U * 600U / 12U);
}

/// Walks home, patrols, wanders: a day of three errands.
Brain walker() {
    Brain m;
    m.name = "walker";
    m.states.resize(3);
    m.states[0].name = "patrol";
    m.states[0].action = ActionKind::kPatrol;
    m.states[0].radius_m = 15.0F;
    m.states[0].speed_factor = 0.5F;
    m.states[0].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 100.0F, 0.0F}};
    m.states[1].name = "return";
    m.states[1].action = ActionKind::kReturn;
    m.states[1].transitions = {{2, Sensor::kHomeDistance, Compare::kBelow, 1.5F, 0.5F}};
    m.states[2].name = "wander";
    m.states[2].action = ActionKind::kWander;
    m.states[2].radius_m = 30.0F;
    m.states[2].speed_factor = 0.7F;
    m.states[2].transitions = {{0, Sensor::kTimeInState, Compare::kAbove, 60.0F, 0.0F}};
    return m;
}

/// The largest distance of off-screen agents from their simulated places, m.
float worst_place(Lives& all, Lives& some) {
    float worst = 0.0F;
    for (std::uint32_t id = 1; id <= 20; ++id) {
        const Agent& agent = *some.field.agents.find(EntityId(id));
        EXPECT_EQ(agent.tier, Tier::kSuspended);
        const Vec3& walked = all.field.position(id);
        const Vec2 at = position_at(agent.segment, some.field.now - 1, kDt);
        worst = std::max(worst, (at - Vec2(walked.x(), walked.z())).norm());
    }
    return worst;
}

class Errand : public testing::TestWithParam<ActionKind> {};

/// A body is corrected where it is 0.2 m from its timetable's position. A tick's distance more (2.8
/// m/s / 30) may pass before that. It wanders on from the timetable's position, so errors do not
/// add up.
TEST_P(Errand, LeadsToWhereTheyWouldHaveWalked) {
    Brain brain = single(GetParam(), 25.0F);
    brain.states[0].speed_factor = 0.7F;
    Lives all(brain, true);
    Lives some(brain, false);
    for (int minute = 1; minute <= 10; ++minute) {
        all.run(60.0F);
        some.run(60.0F);
        EXPECT_LT(worst_place(all, some), 0.2F + 2.8F / 30.0F);
    }
    EXPECT_LT(some.active, 20U * 100U);
}

INSTANTIATE_TEST_SUITE_P(Offscreen,
                         Errand,
                         testing::Values(ActionKind::kIdle,
                                         ActionKind::kPatrol,
                                         ActionKind::kWander,
                                         ActionKind::kReturn));

TEST(Offscreen, WalkersDoWhatTheyWouldHaveDoneAtTheSameTicks) {
    Lives all(walker(), true);
    Lives some(walker(), false);
    all.run(600.0F);
    some.run(600.0F);
    for (std::uint32_t id = 1; id <= 20; ++id) {
        EXPECT_EQ(all.lives[id - 1], some.lives[id - 1]) << id;
        EXPECT_GT(all.lives[id - 1].size(), 9U) << "it did something";
    }
    EXPECT_LT(some.active, 20U * 100U);
}

/// Wanders far, and would take another action near home or very far from it.
Brain rover() {
    Brain m;
    m.name = "rover";
    m.states.resize(2);
    m.states[0].name = "roam";
    m.states[0].action = ActionKind::kWander;
    m.states[0].radius_m = 200.0F;
    m.states[0].transitions = {{1, Sensor::kHomeDistance, Compare::kBelow, 20.0F, 0.0F},
                               {1, Sensor::kHomeDistance, Compare::kAbove, 1e3F, 0.0F}};
    m.states[0].transitions[0].also = {{kStateTime, Compare::kAbove, 10.0F}};
    m.states[1].name = "rest";
    m.states[1].transitions = {{0, Sensor::kTimeInState, Compare::kAbove, 3.0F, 0.0F}};
    return m;
}

/// A straight walk either comes within 20 m of home or never does. It is checked at its start, at
/// its end, and at the decisions by which it may have entered and left the circle. Checks at each
/// half of the remainder would be some six for a walk of 100 m and more.
TEST(Offscreen, WalkersAreLeftAloneUntilTheirWayLeadsSomewhere) {
    Lives all(rover(), true);
    Lives some(rover(), false);
    all.run(1'200.0F);
    some.run(1'200.0F);
    std::size_t entered = 0;
    for (std::uint32_t id = 1; id <= 20; ++id) {
        EXPECT_EQ(all.lives[id - 1], some.lives[id - 1]) << id;
        entered += some.lives[id - 1].size();
    }
    EXPECT_GT(entered, 20U * 5U) << "they came home now and then";
    // Two points of a disc of 200 m are 128/45 pi x 200 m = 181 m apart on average: 45 s.
    const double walks = 20.0 * 1'200.0 / 45.0;
    EXPECT_LT(static_cast<double>(some.events), 2.0 * walks + 4.0 * static_cast<double>(entered));
}

/// `of` with all fields changed that concern the end of a segment, from `then`.
Agent walked_on(Agent of, const Agent& then) {
    std::vector<std::uint64_t> numbers;
    visit_walk_fields(then, [&numbers](const auto& number) {
        numbers.push_back(0);
        std::memcpy(&numbers.back(), &number, sizeof(number));
    });
    std::size_t next = 0;
    visit_walk_fields(
        of, [&](auto& number) { std::memcpy(&number, &numbers[next++], sizeof(number)); });
    return of;
}

/// Hashes of such events leave the rest of an agent out.
TEST(Offscreen, WhereALegEndsNothingChangesButTheWalk) {
    const auto hash_of = [](const Agent& agent) {
        core::StateHash hash;
        ai::hash(hash, agent);
        return hash.value();
    };
    for (const Brain& brain : {walker(), rover(), drowsy()}) {
        Lives some(brain, false);
        some.run(10.0F);
        int ends = 0;
        int changed = 0;
        for (int tick = 0; tick < 18'000; ++tick) {
            std::vector<Agent> before;
            for (std::uint32_t id = 1; id <= 20; ++id) {
                before.push_back(*some.field.agents.find(EntityId(id)));
            }
            const Tick now = some.field.now;
            some.field.step();
            for (const Agent& was : before) {
                const Agent& is = *some.field.agents.find(was.entity);
                if (was.next_event == now && was.next_decision > now) {
                    ++ends;
                    changed += hash_of(was) != hash_of(is) ? 1 : 0;
                    ASSERT_EQ(hash_of(walked_on(was, is)), hash_of(is)) << tick;
                }
            }
        }
        EXPECT_EQ(changed, ends);
        EXPECT_EQ(ends > 100, brain.name != "drowsy") << "who never walks ends no segment";
    }
}

TEST(Offscreen, ResumesWhereAViewerComes) {
    Lives some(walker(), false);
    some.run(30.0F);
    ASSERT_TRUE(some.field.agents.active().empty());
    const Vec2 at =
        position_at(some.field.agents.find(EntityId(3))->segment, some.field.now - 1, kDt);
    some.field.add_player(900, Vec3(at.x() + 30.0F, 0.9F, at.y()));
    some.field.step();
    const Agent& agent = *some.field.agents.find(EntityId(3));
    EXPECT_EQ(agent.tier, Tier::kActive) << "at once";
    EXPECT_NEAR(some.field.position(3).x(), at.x(), 0.2F);
    EXPECT_NEAR(some.field.position(3).z(), at.y(), 0.2F);
    EXPECT_EQ(some.field.agents.find(EntityId(20))->tier, Tier::kSuspended) << "it is far away";
    some.field.entities.remove(some.field.entities.find(EntityId(900)));
    some.run(4.0F);
    EXPECT_EQ(agent.tier, Tier::kSuspended) << "when nobody looks any more";
}

TEST(Offscreen, IsNotSuspendedWhileSomebodyCouldSee) {
    Lives some(drowsy(), false);
    some.field.add_player(900, Vec3(15.0F, 0.9F, 0.0F));
    some.run(10.0F);
    EXPECT_EQ(some.field.agents.find(EntityId(1))->tier, Tier::kActive);
    EXPECT_EQ(some.field.agents.find(EntityId(20))->tier, Tier::kSuspended);
}

}  // namespace
}  // namespace zoned::ai
