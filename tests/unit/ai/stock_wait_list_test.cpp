// build: computes
// Off-screen agents wait for stock instead of checking it. Their actions, goods and the remaining
// stock are the same to the last bit as if they had checked it at each decision.
#include "server/ai/serialization/serialize_agents.h"
#include "server/compute/worker_pool.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

namespace zoned::ai {
namespace {

using namespace test;

constexpr std::size_t kStocks = 3;
constexpr std::size_t kVariables = 2;

constexpr std::uint64_t kSeeds = 16;

/// One stock grows, one is filled and emptied by agents, one shrinks.
PoiSettings stores() {
    PoiSettings settings;
    settings.points_of_interest = {{"depot", {0.0, 0.0}, 3.0F, {{"parcel", 3.0F, 10.0F, 0.7F}}},
                                   {"well", {2.0, 0.0}, 3.0F, {{"water", 0.0F, 4.0F, 0.0F}}},
                                   {"cellar", {0.0, 2.0}, 3.0F, {{"ice", 6.0F, 8.0F, -0.11F}}}};
    settings.day_s = 47.0;
    return settings;
}

/// State machines of four states that act by stock, by own goods, by time and by chance, without
/// sense. Some follow a tree, some a plan.
class MachineMaker {
  public:
    explicit MachineMaker(std::uint64_t seed) : rng_(seed) {}

    Brain make() {
        for (;;) {
            Brain m = try_to();
            const auto& tree = std::get<TreeChoice>(m.states[1].choice).def;
            if (state_machine::defects_of(state_machine_of(m), senses_of(m)).empty() &&
                tree::defects_of(tree, senses_of(m)).empty()) {
                return m;
            }
        }
    }

  private:
    Brain try_to() {
        Brain m;
        m.name = "made";
        m.decide_every_s = pick({kDt, 0.2F, 0.5F, 3.0F});
        for (std::size_t v = 0; v < kVariables; ++v) {
            m.variables.push_back({"v" + std::to_string(v), 1.0F, rate(), 0.0F, 3.0F});
        }
        for (std::size_t s = 0; s < kStocks; ++s) {
            m.points_of_interest.push_back({static_cast<std::uint16_t>(s), 0, "stock"});
        }
        m.states.resize(4);
        for (std::uint16_t s = 0; s < 4; ++s) {
            BrainState& state = m.states[s];
            state.name = "state" + std::to_string(s);
            // Some walk to and fro meanwhile, out of the places and back.
            state.action = rng_.below(3) == 0 ? ActionKind::kWander : ActionKind::kIdle;
            state.radius_m = 6.0F;
            state.speed_factor = 0.5F;
            for (std::uint32_t t = rng_.below(2) + 1; t > 0; --t) {
                const auto to = static_cast<std::uint16_t>((s + 1 + rng_.below(3)) % 4);
                state.transitions.push_back(transition(to));
            }
            fill(state);
        }
        choose(m);
        return m;
    }

    float pick(std::initializer_list<float> of) {
        return *(of.begin() + rng_.below(static_cast<std::uint32_t>(of.size())));
    }

    float rate() { return pick({0.0F, 0.0F, 0.31F, -0.17F}); }

    Compare compare() { return rng_.below(2) == 0 ? Compare::kBelow : Compare::kAbove; }

    Condition on_stock() {
        const auto sense = static_cast<SenseIndex>(kOwnSenses + kVariables + rng_.below(kStocks));
        return {sense, compare(), pick({0.0F, 0.5F, 1.0F, 2.0F, 3.9F, 5.0F})};
    }

    Condition condition() {
        switch (rng_.below(6)) {
            case 0:
                return {static_cast<SenseIndex>(kOwnSenses + rng_.below(kVariables)),
                        compare(),
                        pick({0.2F, 1.0F, 2.7F})};
            case 1:
                return {kSenseRandom, compare(), pick({0.1F, 0.9F})};
            case 2:
                return {kSenseTimeOfDay, compare(), pick({5.0F, 30.0F})};
            default:
                return on_stock();
        }
    }

    Transition transition(std::uint16_t to) {
        Transition t;
        t.to = to;
        t.threshold = pick({0.0F, 0.4F, 2.0F, 11.0F});
        t.hold_s = pick({0.0F, 0.0F, 0.0F, 0.7F});
        for (std::uint32_t k = rng_.below(3); k > 0; --k) {
            t.also.push_back(condition());
        }
        return t;
    }

    /// The events: trades and changes.
    void fill(BrainState& state) {
        for (std::uint32_t t = rng_.below(3); t > 0; --t) {
            const auto place = static_cast<std::uint16_t>(rng_.below(kStocks));
            const float amount = pick({1.0F, -1.0F, 0.5F, -2.0F, 2.0F});
            Trade trade{place, {{static_cast<std::uint16_t>(rng_.below(kVariables)), 0, amount}}};
            if (rng_.below(3) == 0) {
                trade.items.push_back(
                    {static_cast<std::uint16_t>(rng_.below(kVariables)), -1, pick({0.5F, -0.5F})});
            }
            state.trades.push_back(trade);
        }
        const auto v = static_cast<std::uint16_t>(rng_.below(kVariables));
        state.changes = {{v, rate(), pick({0.0F, 0.4F, -0.4F})}};
    }

    BrainState action_named(const std::string& name) {
        BrainState state;
        state.name = name;
        fill(state);
        return state;
    }

    void choose(Brain& m) {
        TreeChoice tree;
        tree.def.name = "tree";
        tree.def.nodes.resize(5);
        tree.def.nodes[0] = {"a", on_stock(), 1, 2, 0};
        tree.def.nodes[1] = {"b", condition(), 3, 4, 0};
        tree.def.nodes[2].action = 0;
        tree.def.nodes[3].action = 1;
        tree.def.nodes[4].action = 2;
        m.states[1].trades.clear();
        m.states[1].choice = tree;
        m.states[1].actions = {action_named("x"), action_named("y"), action_named("z")};
        PlanChoice plan;
        plan.domain.facts = {"full", "fine", "done"};
        plan.domain.actions = {
            {"fetch", {}, {1, 0}, 1}, {"mend", {}, {2, 0}, 2}, {"do", {3, 0}, {4, 0}, 1}};
        plan.domain.goals = {{"goal", {4, 0}}};
        plan.facts = {{on_stock()}, {on_stock(), condition()}, {condition(), on_stock()}};
        m.states[2].trades.clear();
        m.states[2].choice = plan;
        m.states[2].actions = {action_named("fetch"), action_named("mend"), action_named("do")};
    }

    core::Rng rng_;
};

/// The interferences with a world from outside.
struct Outside {
    const char* name = "Nothing";
    bool stock = false;    ///< the stock is set anew now and then
    bool viewer = false;   ///< a player comes into view now and then
    bool moves = false;    ///< agents are taken out and put back
    bool reads = false;    ///< everything is saved and loaded again
    bool forgets = false;  ///< the fault to be found: agents are not notified of stock
};

/// A hundred agents with random brains, all of them at the places where they trade.
class Stores {
  public:
    Stores(std::uint64_t seed, bool simulated, std::uint32_t count = 100) : count_(count) {
        MachineMaker maker(seed);
        field.settings.brains = {maker.make(), maker.make(), maker.make()};
        field.settings.viewer_range_m = simulated ? std::numeric_limits<float>::infinity() : 40.0F;
        field.settings.suspend_after_s = 0.3F;
        field.settings.max_decisions_per_tick = 100'000;
        field.points_of_interest = PointsOfInterest(stores(), Vec2d::Zero(), kDt);
        compile(field.settings, kDt);
        core::Rng rng(seed, 1);
        for (std::uint32_t id = 1; id <= count; ++id) {
            const auto brain = static_cast<std::uint16_t>(rng.below(3));
            field.add_npc(id, kGuard, brain, Vec3(0.5F, 0.9F, 0.5F));
            field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
            begin(*field.agents.find(EntityId(id)), field.settings.compiled[brain], 0);
        }
    }

    void step(const Outside& outside) {
        const Tick second = static_cast<Tick>(1.0F / kDt);
        if (outside.stock && field.now % (7 * second) == 11) {
            std::vector<PointsOfInterest::Stock> stock(field.points_of_interest.stocks().begin(),
                                                       field.points_of_interest.stocks().end());
            for (PointsOfInterest::Stock& one : stock) {
                one.amount = field.now % 2 == 0 ? 0.0F : one.high;
                one.at = field.now;
            }
            field.points_of_interest.set_stocks(stock);
        }
        if (outside.viewer && field.now % (20 * second) == 10 * second) {
            field.add_player(900, Vec3(20.0F, 0.9F, 0.0F));
        }
        if (outside.viewer && field.now > 0 && field.now % (20 * second) == 0) {
            field.entities.remove(field.entities.find(EntityId(900)));
        }
        if (outside.moves && field.now % 13 == 0) {
            const EntityId id(1 + static_cast<std::uint32_t>(field.now) % count_);
            field.agents.add(field.agents.take(id));
        }
        if (outside.reads && field.now % 97 == 0) {
            std::vector<std::uint8_t> bytes;
            save_agents(field.agents, field.steps, field.points_of_interest, bytes);
            ASSERT_EQ(
                load_agents(
                    bytes, field.settings, field.agents, field.steps, field.points_of_interest),
                "");
        }
        const AiReport report = field.step();
        events += report.events;
        trades += report.trades;
        for (std::uint32_t id = 1; id <= count_; ++id) {
            Agent& agent = *field.agents.find(EntityId(id));
            waited += agent.wait.any() ? 1U : 0U;
            if (outside.forgets && agent.wait.any()) {
                agent.wait = StockWait{};
                field.agents.schedule(field.agents.slot_of(EntityId(id)), 1);
            }
        }
    }

    /// Everything that an observer can see.
    [[nodiscard]] std::uint64_t told() const {
        core::StateHash hash;
        field.points_of_interest.hash(hash);
        for (std::uint32_t id = 1; id <= count_; ++id) {
            const Agent& agent = *field.agents.find(EntityId(id));
            const CompiledBrain& brain = field.settings.compiled[agent.brain];
            hash.add(agent.state_machine.leaf);
            hash.add(agent.state_machine.since[0]);
            hash.add(agent.current_action);
            hash.add(agent.wants);
            for (std::size_t v = 0; v < brain.variables.size(); ++v) {
                hash.add(variable_at(agent, brain, v, field.now));
            }
        }
        return hash.value();
    }

    Field field;
    std::uint64_t events = 0;
    std::uint64_t trades = 0;
    std::uint64_t waited = 0;  ///< agents x ticks

  private:
    std::uint32_t count_;
};

/// The tick at which an observer can tell the worlds apart; -1: none.
Tick first_difference(Stores& all, Stores& some, const Outside& outside, float seconds) {
    Outside plain = outside;
    plain.forgets = plain.moves = plain.reads = false;
    const auto end = static_cast<Tick>(seconds / kDt);
    while (all.field.now < end) {
        all.step(plain);
        some.step(outside);
        if (all.told() != some.told()) {
            return all.field.now;
        }
    }
    return -1;
}

class WaitingAgents : public testing::TestWithParam<Outside> {};

TEST_P(WaitingAgents, DoWhatTheyWouldHaveDoneLookingAtEachDecision) {
    std::uint64_t trades = 0;
    std::uint64_t waited = 0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        Stores all(seed, true);
        Stores some(seed, false);
        EXPECT_EQ(first_difference(all, some, GetParam(), 60.0F), -1) << "seed " << seed;
        trades += some.trades;
        waited += some.waited;
    }
    EXPECT_GT(trades, kSeeds * 100U) << "they trade";
    EXPECT_GT(waited, kSeeds * 100U * 180U) << "they wait, a tenth of the time at least";
}

INSTANTIATE_TEST_SUITE_P(StockWaitList,
                         WaitingAgents,
                         testing::Values(Outside{"LeftAlone"},
                                         Outside{"WithStockThatIsSet", true},
                                         Outside{"WithViewers", false, true},
                                         Outside{"WhereAgentsComeAndGo", true, false, true},
                                         Outside{"WithAllOfIt", true, true, true, true}),
                         [](const testing::TestParamInfo<Outside>& tested) {
                             return std::string(tested.param.name);
                         });

TEST(StockWaitList, AreMissedWhereNobodyIsTold) {
    int different = 0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        Stores all(seed, true);
        Stores some(seed, false);
        different += first_difference(
                         all, some, {"Forgetful", false, false, false, false, true}, 60.0F) >= 0;
    }
    EXPECT_GT(different, 10) << "the comparison finds who is not told";
}

std::uint64_t hash_of_agents(const Stores& stores) {
    core::StateHash hash;
    stores.field.agents.hash(hash);
    stores.field.steps.hash(stores.field.agents, hash);
    return hash.value();
}

TEST(StockWaitList, DoNotDependOnThreads) {
    Stores one(3, false, 2'000);
    Stores two(3, false, 2'000);
    compute::WorkerPool pool(2);
    two.field.team.join_pool(pool);
    for (int tick = 0; tick < 600; ++tick) {
        one.step({});
        two.step({});
        ASSERT_EQ(hash_of_agents(one), hash_of_agents(two)) << "tick " << tick;
    }
}

TEST(StockWaitList, GoOnBitForBitWhereTheyAreReadAgain) {
    Stores one(5, false);
    Stores two(5, false);
    for (int tick = 0; tick < 1'800; ++tick) {
        one.step({});
        two.step({"Read", false, false, false, true});
        ASSERT_EQ(hash_of_agents(one), hash_of_agents(two)) << "tick " << tick;
    }
    EXPECT_GT(one.waited, 0U);
}

/// Takes a parcel where there is one, then waits for the next for as long as it lives.
Brain taker() {
    Brain m;
    m.name = "taker";
    m.decide_every_s = 0.2F;
    m.variables = {{"parcels", 0.0F, 0.0F, 0.0F, 1e6F}};
    m.states.resize(2);
    m.states[0].name = "take";
    m.states[0].trades = {{0, {{0, 0, 1.0F}}}};
    m.states[0].transitions = {{1, Sensor::kTimeInState, Compare::kAbove, 1e6F, 0.0F}};
    m.states[1].name = "never";
    m.states[1].transitions = {{0, Sensor::kTimeInState, Compare::kAbove, 1e6F, 0.0F}};
    return m;
}

class HerdAtADepot : public testing::Test {
  protected:
    void fill(std::uint32_t count) {
        field.settings.brains = {taker()};
        field.settings.viewer_range_m = 40.0F;
        field.settings.suspend_after_s = 0.3F;
        PoiSettings depot;
        depot.points_of_interest = {{"depot", {0.0, 0.0}, 3.0F, {{"parcel", 0.0F, 1e5F, 0.5F}}}};
        field.points_of_interest = PointsOfInterest(depot, Vec2d::Zero(), kDt);
        compile(field.settings, kDt);
        for (std::uint32_t id = 1; id <= count; ++id) {
            field.add_npc(id, kGuard, 0, Vec3(0.5F, 0.9F, 0.5F));
            field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
            begin(*field.agents.find(EntityId(id)), field.settings.compiled[0], 0);
        }
    }

    Field field;
};

TEST_F(HerdAtADepot, IsNotCalledUpAsAWhole) {
    fill(3'000);
    field.settings.max_decisions_per_tick = 100'000;
    field.run(3.0F);
    ASSERT_TRUE(field.agents.active().empty());
    std::uint32_t events = 0;
    std::uint32_t trades = 0;
    for (const Tick end = field.now + 60 * 30; field.now < end;) {
        const AiReport report = field.step();
        events += report.events;
        trades += report.trades;
    }
    EXPECT_EQ(trades, 30U) << "half a parcel a second";
    EXPECT_EQ(events, trades) << "who gets one comes up, nobody else";
}

TEST_F(HerdAtADepot, WaitsItsTurnWhereDecisionsAreFew) {
    fill(100);
    field.settings.max_decisions_per_tick = 3;
    field.run(30.0F);
    ASSERT_TRUE(field.agents.active().empty());
    std::vector<PointsOfInterest::Stock> stock(field.points_of_interest.stocks().begin(),
                                               field.points_of_interest.stocks().end());
    stock[0].amount = 1e4F;
    stock[0].at = field.now;
    field.points_of_interest.set_stocks(stock);
    const Tick end = field.now + 6 + 34;  // a period, and ceil(100 / 3)
    std::uint32_t trades = 0;
    while (field.now < end) {
        const AiReport report = field.step();
        EXPECT_LE(report.decisions, 3U);
        trades += report.trades;
    }
    for (std::uint32_t id = 1; id <= 100; ++id) {
        const Agent& agent = *field.agents.find(EntityId(id));
        EXPECT_EQ(agent.wants, 0) << id;
    }
    EXPECT_GT(trades, 0U);
}

}  // namespace
}  // namespace zoned::ai
