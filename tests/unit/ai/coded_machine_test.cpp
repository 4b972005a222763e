// build: computes
// State machines in code: names are resolved whatever their order, mistakes are refused, and agents
// with code live as agents with the same machine as data, seen and unseen.
#include "server/ai/decision/state_machine/state_diagram.h"
#include "server/ai/explain.h"
#include "server/ai/serialization/serialize_agents.h"
#include "tests/scenario/brave.h"
#include "tests/scenario/sentry.h"
#include "tests/unit/ai/field.h"
#include "tests/unit/allocation_count.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>

namespace zoned::ai {
namespace {

using namespace test;
using state_machine::BoundMachine;
using state_machine::CodedMachine;
using state_machine::CodedMachines;
using state_machine::CodedTurn;

// ---------------------------------------------------------------- names

const std::vector<std::string> kSentryLeaves =
    {"patrol", "listen", "chase", "fight", "flee", "rest"};

std::string why_not_bound(const CodedMachine& machine,
                          const std::vector<std::string>& leaves = kSentryLeaves) {
    const auto bound =
        BoundMachine::bind(machine, leaves, scenario::sentry_sense_names(), scenario::kSentryDt);
    return bound.ok() ? "" : bound.error();
}

/// The states of an agent by name and the time of its last change, whatever its numbers are.
struct NamedLife {
    std::string state;
    Tick since = 0;
    std::string held;  ///< the transition that it holds, by name
    Tick held_since = 0;

    friend bool operator==(const NamedLife&, const NamedLife&) = default;
};

/// Agents and senses whose names come in a drawn order.
class ShuffledSentry {
  public:
    ShuffledSentry(bool objects, core::Rng& rng) : code_(scenario::sentry_code(objects)) {
        leaves_ = kSentryLeaves;  // all begin on patrol
        senses_ = scenario::sentry_sense_names();
        senses_.insert(senses_.begin(), {"other", "another"});
        for (std::size_t k = leaves_.size() - 1; k > 1; --k) {
            std::swap(leaves_[k], leaves_[1 + rng.below(static_cast<std::uint32_t>(k))]);
        }
        for (std::size_t k = senses_.size() - 1; k > 0; --k) {
            std::swap(senses_[k], senses_[rng.below(static_cast<std::uint32_t>(k) + 1)]);
        }
        bound_.emplace(BoundMachine::bind(code_, leaves_, senses_, scenario::kSentryDt).value());
    }

    NamedLife tick(std::span<const float> sentry_senses, Tick now) {
        std::vector<float> values(senses_.size(), std::numeric_limits<float>::quiet_NaN());
        const std::vector<std::string> names = scenario::sentry_sense_names();
        for (std::size_t k = 0; k < names.size(); ++k) {
            const auto at = std::find(senses_.begin(), senses_.end(), names[k]);
            values[static_cast<std::size_t>(at - senses_.begin())] = sentry_senses[k];
        }
        bound_->decide(state_, values, now);
        const bool holds = state_.pending != state_machine::kNone;
        return {leaves_[state_.leaf],
                state_.since[0],
                holds ? code_.transitions[state_.pending] : "",
                holds ? state_.pending_since : 0};
    }

  private:
    CodedMachine code_;
    std::vector<std::string> leaves_;
    std::vector<std::string> senses_;
    std::optional<BoundMachine> bound_;
    state_machine::ActiveState state_;
};

/// All transitions fire in FsmForms with the same walk, 1000 agents and 1500 ticks.
TEST(CodedMachine, MeansTheSameWhateverTheOrderOfTheConfigsNames) {
    const state_machine::FlatStateMachine table = state_machine::compile(
        scenario::sentry_def(), scenario::kSentrySenses, scenario::kSentryDt);
    const std::vector<std::string> transitions = scenario::sentry_code(false).transitions;
    core::Rng order(3);
    core::Rng walk(11);
    std::set<std::uint16_t> taken;
    for (int run = 0; run < 40; ++run) {
        ShuffledSentry shuffled(run % 2 == 1, order);
        scenario::Sensed sensed(scenario::kSentrySenses, 1);
        state_machine::ActiveState state;
        for (Tick now = 0; now < 3000; ++now) {
            scenario::sentry_walk(sensed, 1, walk);
            const auto change = state_machine::step(table, state, sensed.of(0), now);
            if (change) {
                taken.insert(change->transition);
            }
            const bool holds = state.pending != state_machine::kNone;
            const NamedLife expected{table.state_name(state.leaf),
                                     state.since[0],
                                     holds ? transitions[state.pending] : "",
                                     holds ? state.pending_since : 0};
            ASSERT_EQ(shuffled.tick(sensed.of(0), now), expected) << run << " at " << now;
        }
    }
    EXPECT_EQ(taken.size(), 12U) << "the walks lead through all transitions";
}

TEST(CodedMachine, IsRefusedWithTheNameThatIsMissing) {
    EXPECT_EQ(why_not_bound(scenario::sentry_code(false)), "");
    EXPECT_EQ(
        why_not_bound(scenario::sentry_code(false), {"patrol", "listen", "chase", "flee", "rest"}),
        "has no state named 'fight', which code 'sentry' uses");
    EXPECT_EQ(why_not_bound(scenario::sentry_code(true),
                            {"patrol", "listen", "chase", "fight", "flee", "rest", "sleep"}),
              "has a state named 'sleep', which code 'sentry objects' does not use");
    CodedMachine machine = scenario::sentry_code(false);
    machine.senses.push_back("smell");
    EXPECT_EQ(why_not_bound(machine), "does not sense 'smell', which code 'sentry' reads");
}

TEST(CodedMachine, IsRefusedWherePartsAreMissing) {
    CodedMachine machine = scenario::sentry_code(true);
    machine.decision = &scenario::sentry_decide;
    EXPECT_EQ(why_not_bound(machine), "code 'sentry objects' needs either a function or objects");
    machine = scenario::sentry_code(false);
    machine.decision = nullptr;
    EXPECT_EQ(why_not_bound(machine), "code 'sentry' needs either a function or objects");
    machine = scenario::sentry_code(true);
    machine.objects.pop_back();
    EXPECT_EQ(why_not_bound(machine),
              "code 'sentry objects' needs an object for each of its states");
    machine.objects.push_back(nullptr);
    EXPECT_EQ(why_not_bound(machine), "code 'sentry objects' has a state without an object");
    machine = scenario::sentry_code(false);
    machine.states.back() = "flee";
    EXPECT_EQ(why_not_bound(machine), "code 'sentry' names state 'flee' twice");
}

using CodedMachineDeathTest = ::testing::Test;

TEST(CodedMachineDeathTest, StopsAtNumbersThatCodeHasNotRegistered) {
    const auto decide_by = [](state_machine::CodedDecision decision) {
        CodedMachine machine;
        machine.name = "astray";
        machine.states = {"here", "there"};
        machine.transitions = {"go"};
        machine.decision = decision;
        const std::vector<std::string> leaves = {"here", "there"};
        const BoundMachine bound = BoundMachine::bind(machine, leaves, {}, 0.1F).value();
        state_machine::ActiveState state;
        bound.decide(state, {}, 1);
        return state.leaf;
    };
    EXPECT_EQ(decide_by([](CodedTurn& turn, std::span<const float>) { turn.enter(1, 0); }), 1U);
    EXPECT_DEATH(decide_by([](CodedTurn& turn, std::span<const float>) { turn.enter(2, 0); }),
                 "has registered");
    EXPECT_DEATH(decide_by([](CodedTurn& turn, std::span<const float>) { turn.enter(1, 1); }),
                 "has registered");
    EXPECT_DEATH(
        decide_by([](CodedTurn& turn, std::span<const float>) { turn.when(true, 1, 1.0F); }),
        "has registered");
    EXPECT_DEATH(decide_by([](CodedTurn& turn, std::span<const float>) {
                     turn.enter(1, 0);
                     turn.enter(0, 0);
                 }),
                 "one state");
}

// ---------------------------------------------------------------- agents

enum TrampSense : std::size_t {
    kHomeM,
    kLuck,
    kHunger,
    kPlayerM,
};

enum TrampState : std::uint16_t {
    kRoam,
    kEat,
    kGoHome,
    kHide,
};

/// Roams, eats when it has long been hungry, goes home by chance or from afar, hides from players.
Brain tramp_as_data() {
    Brain m;
    m.name = "tramp";
    m.variables = {{"hunger", 0.3F, 0.013F, 0.0F, 1.0F}};
    m.states.resize(4);
    const auto hungry = static_cast<SenseIndex>(kOwnSenses);
    m.states[kRoam].name = "roam";
    m.states[kRoam].action = ActionKind::kWander;
    m.states[kRoam].radius_m = 30.0F;
    m.states[kRoam].transitions = {
        {kHide, Sensor::kPlayerDistance, Compare::kBelow, 12.0F, 0.4F},
        {kEat, Sensor::kTimeInState, Compare::kAbove, 0.7F, 1.3F, hungry},
        {kGoHome, Sensor::kRandom, Compare::kBelow, 0.01F},
        {kGoHome, Sensor::kHomeDistance, Compare::kAbove, 25.0F, 0.6F}};
    m.states[kEat].name = "eat";
    m.states[kEat].changes = {{0, -0.11F, -0.05F}};
    m.states[kEat].transitions = {
        {kRoam, Sensor::kTimeInState, Compare::kBelow, 0.11F, 0.0F, hungry}};
    m.states[kGoHome].name = "go home";
    m.states[kGoHome].action = ActionKind::kReturn;
    m.states[kGoHome].transitions = {{kRoam, Sensor::kHomeDistance, Compare::kBelow, 1.5F, 0.5F},
                                     {kEat, Sensor::kTimeInState, Compare::kAbove, 30.0F}};
    m.states[kHide].name = "hide";
    m.states[kHide].transitions = {{kRoam, Sensor::kTimeInState, Compare::kAbove, 3.0F}};
    return m;
}

void decide_tramp(CodedTurn& turn, std::span<const float> senses) {
    switch (turn.state()) {
        case kRoam:
            if (turn.when(senses[kPlayerM] < 12.0F, 0, 0.4F)) {
                return turn.enter(kHide, 0);
            }
            if (turn.when(senses[kHunger] > 0.7F, 1, 1.3F)) {
                return turn.enter(kEat, 1);
            }
            if (turn.when(senses[kLuck] < 0.01F, 2)) {
                return turn.enter(kGoHome, 2);
            }
            if (turn.when(senses[kHomeM] > 25.0F, 3, 0.6F)) {
                return turn.enter(kGoHome, 3);
            }
            break;
        case kEat:
            if (turn.when(senses[kHunger] < 0.11F, 4)) {
                return turn.enter(kRoam, 4);
            }
            break;
        case kGoHome:
            if (turn.when(senses[kHomeM] < 1.5F, 5, 0.5F)) {
                return turn.enter(kRoam, 5);
            }
            if (turn.when(turn.time_in_state() > 30.0F, 6)) {
                return turn.enter(kEat, 6);
            }
            break;
        default:
            if (turn.when(turn.time_in_state() > 3.0F, 7)) {
                return turn.enter(kRoam, 7);
            }
            break;
    }
}

CodedMachines tramp_code() {
    CodedMachine machine;
    machine.name = "tramp";
    machine.states = {"roam", "eat", "go home", "hide"};
    machine.senses = {"HOME_DISTANCE", "RANDOM", "hunger", "PLAYER_DISTANCE"};
    machine.transitions = {"seen", "hungry", "homesick", "far", "full", "home", "lost", "calm"};
    machine.decision = &decide_tramp;
    return {machine};
}

Brain tramp_in_code() {
    Brain brain = tramp_as_data();
    brain.coded = "tramp";
    for (BrainState& state : brain.states) {
        state.transitions.clear();
    }
    return brain;
}

/// Roams while it is bold and there are fish, then rests, until it is at the pond or timid again.
/// Its senses beyond its own: boldness, the way to the pond, fish.
Brain angler_as_data() {
    constexpr SenseIndex kBold = kOwnSenses + 1;
    Brain m;
    m.name = "angler";
    m.variables = {{"vigour", 0.1F, 0.02F, 0.0F, 1.0F}};
    m.fuzzy.push_back({scenario::brave_def(fuzzy::Inference::kSugeno),
                       {kSenseHomeDistance, static_cast<SenseIndex>(kOwnSenses)}});
    m.points_of_interest = {{0, -1, "pond.distance"}, {0, 0, "pond.fish"}};
    m.states.resize(3);
    m.states[0].name = "wait";
    m.states[0].transitions = {{1,
                                Sensor::kTimeInState,
                                Compare::kAbove,
                                0.55F,
                                0.0F,
                                kBold,
                                {{kBold + 2, Compare::kAbove, 6.5F}}}};
    m.states[1].name = "roam";
    m.states[1].action = ActionKind::kWander;
    m.states[1].radius_m = 40.0F;
    m.states[1].changes = {{0, -0.05F, 0.0F}};
    m.states[1].transitions = {{2, Sensor::kTimeInState, Compare::kBelow, 90.0F, 0.0F, kBold + 1},
                               {0, Sensor::kTimeInState, Compare::kBelow, 0.4F, 0.0F, kBold}};
    m.states[2].name = "home";
    m.states[2].action = ActionKind::kReturn;
    m.states[2].transitions = {{0, Sensor::kTimeInState, Compare::kAbove, 12.0F}};
    return m;
}

void decide_angler(CodedTurn& turn, std::span<const float> senses) {
    const float boldness = senses[0];
    const float pond_m = senses[1];
    const float fish = senses[2];
    if (turn.state() == 0 && turn.when(boldness > 0.55F && fish > 6.5F, 0)) {
        return turn.enter(1, 0);
    }
    if (turn.state() == 1 && turn.when(pond_m < 90.0F, 1)) {
        return turn.enter(2, 1);
    }
    if (turn.state() == 1 && turn.when(boldness < 0.4F, 2)) {
        return turn.enter(0, 2);
    }
    if (turn.state() == 2 && turn.when(turn.time_in_state() > 12.0F, 3)) {
        return turn.enter(0, 3);
    }
}

CodedMachine angler_code() {
    CodedMachine machine;
    machine.name = "angler";
    machine.states = {"wait", "roam", "home"};
    machine.senses = {"brave.boldness", "pond.distance", "pond.fish"};
    machine.transitions = {"bold", "at the pond", "timid", "long enough"};
    machine.decision = &decide_angler;
    return machine;
}

Brain angler_in_code() {
    Brain brain = angler_as_data();
    brain.coded = "angler";
    for (BrainState& state : brain.states) {
        state.transitions.clear();
    }
    return brain;
}

/// Tramps or anglers on a plain, and a player who comes by now and then.
class Tramps {
  public:
    static constexpr std::uint32_t kCount = 24;
    static constexpr std::uint32_t kVisitor = 900;

    explicit Tramps(Brain brain,
                    float viewer_range_m = std::numeric_limits<float>::infinity(),
                    std::uint32_t visitors = 0) {
        field.settings.brains = {std::move(brain)};
        field.settings.viewer_range_m = viewer_range_m;
        compile(field.settings, kDt);
        CodedMachines machines = tramp_code();
        machines.push_back(angler_code());
        EXPECT_EQ(bind_code(field.settings, machines), "");
        PoiSettings pond;
        pond.points_of_interest = {{"pond", {0.0, 0.0}, 3.0F, {{"fish", 5.0F, 10.0F, 0.1F}}}};
        field.points_of_interest = PointsOfInterest(pond, Vec2d::Zero(), kDt);
        for (std::uint32_t id = 1; id <= kCount; ++id) {
            field.add_npc(id, kGuard, 0, Vec3(15.0F * static_cast<float>(id), 0.9F, 0.0F));
            field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
            begin(*field.agents.find(EntityId(id)), field.settings.compiled[0], 0);
        }
        if (visitors > 0) {
            field.add_player(kVisitor, Vec3::Zero());
        }
    }

    /// The states entered since the last call, by agent.
    std::vector<std::pair<Tick, std::uint16_t>> step() {
        if (field.entities.find(EntityId(kVisitor)) != world::kNoRow) {
            const float t = static_cast<float>(field.now) * kDt;
            field.position(kVisitor) = Vec3(190.0F + 180.0F * std::sin(0.05F * t), 0.9F, 6.0F);
        }
        const AiReport report = field.step();
        events += report.events;
        suspended += kCount - field.agents.active().size();
        std::vector<std::pair<Tick, std::uint16_t>> now;
        for (std::uint32_t id = 1; id <= kCount; ++id) {
            const Agent& agent = *field.agents.find(EntityId(id));
            now.emplace_back(agent.state_machine.since[0], agent.state_machine.leaf);
            const auto last = leaf.find(id);
            if (last != leaf.end() && last->second != agent.state_machine.leaf) {
                entered.insert({last->second, agent.state_machine.leaf});
                ++changes;
            }
            leaf[id] = agent.state_machine.leaf;
        }
        return now;
    }

    std::uint64_t hash() {
        core::StateHash hash;
        field.agents.hash(hash);
        for (std::uint32_t id = 1; id <= kCount; ++id) {
            hash.add(field.position(id).x());
            hash.add(field.position(id).z());
        }
        return hash.value();
    }

    Field field;
    std::uint64_t events = 0;
    std::uint64_t suspended = 0;  ///< agents, summed over ticks
    std::size_t changes = 0;
    std::set<std::pair<std::uint16_t, std::uint16_t>> entered;  ///< from and to
    std::map<std::uint32_t, std::uint16_t> leaf;
};

TEST(CodedAgents, LiveAsThoseWithTheSameMachineAsData) {
    Tramps data(tramp_as_data(), std::numeric_limits<float>::infinity(), 1);
    Tramps code(tramp_in_code(), std::numeric_limits<float>::infinity(), 1);
    for (int tick = 0; tick < 30 * 300; ++tick) {
        ASSERT_EQ(data.step(), code.step()) << tick;
        ASSERT_EQ(data.hash(), code.hash()) << tick;
    }
    EXPECT_EQ(code.entered.size(), 6U) << "every way from state to state was taken";
}

TEST(CodedAgents, SenseFuzzyOutputsAndPlacesSeenOrNot) {
    Tramps data(angler_as_data());
    Tramps seen(angler_in_code());
    Tramps unseen(angler_in_code(), 50.0F);
    for (int tick = 0; tick < 30 * 300; ++tick) {
        const auto expected = data.step();
        ASSERT_EQ(expected, seen.step()) << tick;
        ASSERT_EQ(expected, unseen.step()) << tick;
    }
    EXPECT_EQ(seen.entered.size(), 4U) << "every way from state to state was taken";
}

TEST(CodedAgents, ChangeAtTheSameTicksUnseen) {
    Tramps seen(tramp_in_code());
    Tramps unseen(tramp_in_code(), 50.0F);
    Tramps data(tramp_as_data(), 50.0F);
    constexpr int kTicks = 30 * 600;
    for (int tick = 0; tick < kTicks; ++tick) {
        const auto expected = seen.step();
        ASSERT_EQ(expected, unseen.step()) << tick;
        ASSERT_EQ(expected, data.step()) << tick;
    }
    EXPECT_GT(unseen.changes, 20U * Tramps::kCount);
    EXPECT_GT(unseen.suspended, Tramps::kCount * (kTicks - 100)) << "nobody sees them";
    // Every decision is an event, and so is every end of a walk: a decision each 0.2 s.
    EXPECT_GE(unseen.events, Tramps::kCount * (kTicks / 6 - 20));
    EXPECT_LT(data.events, unseen.events / 2) << "a forecast spares most of them";
}

TEST(CodedAgents, AllocateNothingForADecision) {
    Tramps tramps(tramp_in_code());
    Agent& agent = *tramps.field.agents.find(EntityId(1));
    DecisionScratch scratch;
    const Percept nobody = Percept::none();
    const std::uint64_t before = allocation_count();
    for (Tick now = 1; now < 2000; ++now) {
        decide(agent,
               tramps.field.settings.compiled[0],
               nobody,
               Vec2(15.0F, 0.0F),
               tramps.field.points_of_interest,
               now,
               scratch);
    }
    EXPECT_EQ(allocation_count(), before);
}

TEST(CodedAgents, GoOnBitForBitWhenReadAgain) {
    Tramps tramps(tramp_in_code(), 50.0F, 1);
    const auto holds = [&tramps] {
        for (std::uint32_t id = 1; id <= Tramps::kCount; ++id) {
            if (tramps.field.agents.find(EntityId(id))->state_machine.pending ==
                state_machine::kNone) {
                continue;
            }
            return true;
        }
        return false;
    };
    int ticks = 0;
    while (++ticks < 30 * 120 && (ticks < 30 * 60 || !holds())) {
        tramps.step();
    }
    ASSERT_TRUE(holds()) << "some agent holds a transition of the code";
    std::vector<std::uint8_t> bytes;
    save_agents(tramps.field.agents, tramps.field.steps, tramps.field.points_of_interest, bytes);
    Tramps again(tramp_in_code(), 50.0F, 1);
    again.field.now = tramps.field.now;
    again.field.entities = tramps.field.entities;
    again.field.agents = AgentStore();
    ASSERT_EQ(load_agents(bytes,
                          again.field.settings,
                          again.field.agents,
                          again.field.steps,
                          again.field.points_of_interest),
              "");
    for (int tick = 0; tick < 1800; ++tick) {
        tramps.step();
        again.step();
        ASSERT_EQ(tramps.hash(), again.hash()) << "tick " << tick;
    }
    // Code with fewer transitions than an agent's memory names cannot go on with it.
    CodedMachines fewer = tramp_code();
    fewer[0].transitions.clear();
    ASSERT_EQ(bind_code(again.field.settings, fewer), "");
    AgentStore none;
    EXPECT_NE(
        load_agents(
            bytes, again.field.settings, none, again.field.steps, again.field.points_of_interest),
        "");
}

TEST(CodedAgents, AreExplainedByTheNamesOfTheCode) {
    Tramps tramps(tramp_in_code());
    const Brain& brain = tramps.field.settings.brains[0];
    const CompiledBrain& compiled = tramps.field.settings.compiled[0];
    EXPECT_EQ(transition_text(brain, compiled, kRoam, kGoHome, 3), "roam -> go home by code: far");
    Agent& agent = *tramps.field.agents.find(EntityId(1));
    agent.state_machine.pending = 1;
    agent.state_machine.pending_since = 10;
    const std::string text = explain(agent,
                                     brain,
                                     compiled,
                                     Percept::none(),
                                     Vec2::Zero(),
                                     tramps.field.points_of_interest,
                                     40,
                                     kDt);
    EXPECT_NE(text.find("brain tramp, in state:\n  roam for 1.33 s\n"), std::string::npos) << text;
    EXPECT_NE(text.find("transitions by code tramp, which reads: home distance, random, hunger, "
                        "player distance\n  hungry, held 1.00 s\n"),
              std::string::npos)
        << text;
}

TEST(CodedAgents, HaveADiagramOfTheirStates) {
    const std::string text = state_machine::dot_of(state_machine_of(tramp_in_code()), {});
    EXPECT_NE(text.find("label=\"tramp (transitions by code)\""), std::string::npos) << text;
    EXPECT_NE(text.find("\"go home\" [label=\"go home\"]"), std::string::npos) << text;
}

TEST(CodedAgents, NeedCodeThatTheRulesHave) {
    Field field;
    field.settings.brains = {tramp_in_code()};
    compile(field.settings, kDt);
    EXPECT_EQ(bind_code(field.settings, {}),
              "brain 'tramp' names code 'tramp', which these rules do not have");
    EXPECT_EQ(bind_code(field.settings, CodedMachines(2, tramp_code()[0])),
              "brain 'tramp' names code 'tramp', which these rules have twice");
    field.settings.brains[0].variables[0].name = "thirst";
    compile(field.settings, kDt);
    EXPECT_EQ(bind_code(field.settings, tramp_code()),
              "brain 'tramp' does not sense 'hunger', which code 'tramp' reads");
}

}  // namespace
}  // namespace zoned::ai
