// Suite `decisions`: the cost of an agent's decision by each method: state machines in three forms
// and of three levels, plans, fuzzy rules.
#include "server/ai/decision/fuzzy/fuzzy_system.h"
#include "server/ai/decision/goap/goap_planner.h"
#include "server/ai/decision/state_machine/flat_state_machine.h"
#include "tests/bench/comparison.h"
#include "tests/bench/fuzzylite_peer.h"
#include "tests/bench/suite_decisions_learning.h"
#include "tests/bench/suite_decisions_npc.h"
#include "tests/scenario/brave.h"
#include "tests/scenario/gunman.h"
#include "tests/scenario/sentry.h"
#include "tests/scenario/villager.h"
#include "tests/scenario/walked_state_machine.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace zoned::bench {

namespace {

namespace state_machine = ai::state_machine;

// ---------------------------------------------------------------- state machines

enum class Form {
    kSwitch,
    kPattern,
    kTables,
    kLevels,
};

constexpr Tick kNow = 20000;
/// Sets of senses that ticks take turns with.
constexpr std::size_t kSenseSets = 4;

struct MachineScene {
    state_machine::StateMachineDef def;
    std::size_t senses = 0;
    std::vector<float> high;    ///< each sense lies in [0, high]
    std::uint32_t longest = 0;  ///< in a state: 2^longest ticks
    float dt = 0.0F;
};

MachineScene machine_scene(Form form) {
    if (form == Form::kLevels) {
        return {scenario::villager_def(),
                scenario::kVillagerSenses,
                {0.49F, 20.0F, 1.0F, 1.0F},
                9,
                1.0F};
    }
    return {scenario::sentry_def(),
            scenario::kSentrySenses,
            {50.0F, 60.0F, 1.0F, 1.0F},
            8,
            scenario::kSentryDt};
}

/// Agents spread evenly over all states. Most have no reason to leave theirs. On average one in 67
/// senses a value that a transition of its state waits for, and is put back into its state
/// afterwards.
class AgentCrowd {
  public:
    AgentCrowd(const MachineScene& scene, std::size_t count, bool sorted)
        : machine(state_machine::compile(scene.def, scene.senses, scene.dt)),
          states(count),
          sensed(kSenseSets, scenario::Sensed(scene.senses, count)) {
        core::Rng rng(71);
        state_machine::ActiveState one;
        std::vector<float> of_one(scene.senses);
        const auto leaves = static_cast<std::uint32_t>(machine.leaves());
        for (std::size_t i = 0; i < count; ++i) {
            const auto leaf =
                static_cast<std::uint16_t>(sorted ? i * leaves / count : rng.below(leaves));
            one.leaf = leaf;
            for (std::size_t set = 0; set < kSenseSets; ++set) {
                draw(scene, rng, set > 0 && rng.below(50) == 0, set == 0, one, of_one);
                for (std::size_t k = 0; k < scene.senses; ++k) {
                    sensed[set].at(k, i) = of_one[k];
                }
            }
            states[i] = one;
        }
        begun = states;
        changes.reserve(count);
    }

    /// The effects of the tick are undone, so that all ticks see the same crowd.
    void put_back() {
        changed += changes.size();
        ++ticks;
        for (const std::size_t agent : changes) {
            states[agent] = begun[agent];
        }
        changes.clear();
    }

    state_machine::FlatStateMachine machine;
    std::vector<state_machine::ActiveState> states;
    std::vector<state_machine::ActiveState> begun;
    std::vector<scenario::Sensed> sensed;
    std::vector<std::size_t> changes;  ///< agents that left their state in this tick
    std::size_t changed = 0;
    std::size_t ticks = 0;

  private:
    /// Senses that fire a transition, or none; `times` in states are drawn as well, or left
    /// unchanged.
    void draw(const MachineScene& scene,
              core::Rng& rng,
              bool event,
              bool times,
              state_machine::ActiveState& one,
              std::vector<float>& of_one) {
        const std::uint16_t leaf = one.leaf;
        for (int attempt = 0; attempt < 1000; ++attempt) {
            for (std::size_t level = 0; times && level < machine.levels; ++level) {
                one.since[level] = kNow - rng.below(1U << rng.below(scene.longest));
            }
            const auto at = one.since;
            for (std::size_t k = 0; k < scene.senses; ++k) {
                of_one[k] = rng.range(0.0F, scene.high[k]);
            }
            const bool fires = state_machine::step(machine, one, of_one, kNow).has_value();
            const bool happens = fires || one.pending != state_machine::kNone;
            one.leaf = leaf;
            one.since = at;
            one.pending = state_machine::kNone;
            if (happens == event) {
                return;
            }
        }
    }
};

class MachineTrial final : public JudgedTrial {
  public:
    MachineTrial(Form form, std::size_t count, bool sorted)
        : form_(form),
          crowd_(machine_scene(form), count, sorted) {
        if (form == Form::kSwitch || form == Form::kPattern) {
            code_ = scenario::bound_sentry(form == Form::kPattern, crowd_.machine);
        }
    }

    void frame() override {
        const std::size_t turn = crowd_.ticks % kSenseSets;
        for_form([&](auto&& step) {
            for (std::size_t i = 0; i < crowd_.states.size(); ++i) {
                if (step(crowd_.states[i], crowd_.sensed[turn].of(i), kNow)) {
                    crowd_.changes.push_back(i);
                }
            }
        });
        crowd_.put_back();
    }

    /// The number of agents whose state differs from a walk through the definition, over a run of
    /// random senses.
    void judge(Row& row) override {
        row.error_unit = "agents";
        row.metric("changes_per_tick",
                   static_cast<double>(crowd_.changed) / static_cast<double>(crowd_.ticks));
        const MachineScene scene = machine_scene(form_);
        constexpr std::size_t kCount = 300;
        constexpr Tick kTicks = 300;
        std::vector<state_machine::ActiveState> states(kCount);
        std::vector<scenario::WalkedMachine> walked(kCount,
                                                    scenario::WalkedMachine(scene.def, scene.dt));
        scenario::Sensed sensed(scene.senses, kCount);
        std::size_t changes = 0;
        core::Rng rng(73);
        for (Tick now = 0; now < kTicks; ++now) {
            if (form_ == Form::kLevels) {
                scenario::villager_walk(sensed, kCount, rng);
            } else {
                scenario::sentry_walk(sensed, kCount, rng);
            }
            for_form([&](auto&& step) {
                for (std::size_t i = 0; i < kCount; ++i) {
                    changes += step(states[i], sensed.of(i), now) ? 1U : 0U;
                    walked[i].tick(now, sensed.of(i));
                    row.error +=
                        crowd_.machine.state_name(states[i].leaf) == walked[i].name() ? 0.0 : 1.0;
                }
            });
        }
        row.metric("changes_compared", static_cast<double>(changes));
    }

  private:
    /// Calls `use` with the decision of an agent in this form: (state, senses, tick) to whether it
    /// left its state.
    template <class Use>
    void for_form(Use&& use) const {
        switch (form_) {
            case Form::kSwitch:
            case Form::kPattern:
                return use(
                    [this](state_machine::ActiveState& state,
                           std::span<const float> senses,
                           Tick now) { return code_->decide(state, senses, now).has_value(); });
            case Form::kTables:
            case Form::kLevels:
                return use([this](state_machine::ActiveState& state,
                                  std::span<const float> senses,
                                  Tick now) {
                    return state_machine::step(crowd_.machine, state, senses, now).has_value();
                });
        }
    }

    Form form_;
    AgentCrowd crowd_;
    std::optional<state_machine::BoundMachine> code_;  ///< of the forms in code
};

void run_machine(Session& session, const std::string& scene, Form form) {
    const std::size_t count = session.quick ? 5000 : 100000;
    const auto method = [&](const char* name, bool sorted) {
        return Method{name, "", [form, count, sorted] {
                          return std::make_unique<MachineTrial>(form, count, sorted);
                      }};
    };
    if (!session.wants_method("default", "")) {
        return;
    }
    std::vector<Row> rows =
        compare("decisions",
                scene,
                "",
                {method("default", false), method("sorted", true)},
                {4, session.quick ? 8 : 48, session.quick ? 1 : session.repeats});
    const double per_npc = 1e3 / static_cast<double>(count);
    rows[0].metric("ns_per_npc", rows[0].time_us_p50 * per_npc);
    rows[0].metric("ns_per_npc_sorted", rows[1].time_us_p50 * per_npc);
    rows[0].metric("npcs", static_cast<double>(count));
    rows[0].error += rows[1].error;
    rows.pop_back();
    session.add(std::move(rows));
}

// ---------------------------------------------------------------- plans

class PlanTrial final : public JudgedTrial {
  public:
    PlanTrial(ai::goap::Domain domain, ai::goap::FactSet from, std::uint32_t cost)
        : domain_(std::move(domain)),
          actions_(domain_),
          from_(from),
          cost_(cost) {}

    void frame() override { planner_.plan(actions_, from_, domain_.goals[0].wants, plan_); }

    /// `cost_` 0: the goal is out of reach.
    void judge(Row& row) override {
        const ai::goap::Verdict expected =
            cost_ == 0 ? ai::goap::Verdict::kUnreachable : ai::goap::Verdict::kPlanned;
        row.error = plan_.verdict == expected
                        ? static_cast<double>(plan_.cost) - static_cast<double>(cost_)
                        : 1e9;
        row.error_unit = "cost";
        row.metric("steps", plan_.size);
        row.metric("nodes_created", plan_.created);
        row.metric("actions", static_cast<double>(domain_.actions.size()));
    }

  private:
    ai::goap::Domain domain_;
    ai::goap::Actions actions_;
    ai::goap::FactSet from_;
    std::uint32_t cost_;
    ai::goap::GoapPlanner planner_;
    ai::goap::Plan plan_;
};

void run_plan(Session& session, const std::string& scene, bool reachable) {
    const Method method{
        "default", "", [reachable]() -> std::unique_ptr<JudgedTrial> {
            return reachable ? std::make_unique<PlanTrial>(
                                   scenario::gunman_domain(), scenario::kGunmanWorld, 4)
                             : std::make_unique<PlanTrial>(scenario::unreachable_domain(), 0, 0);
        }};
    const std::vector<Method> asked = wanted(session, {method});
    if (asked.empty()) {
        return;
    }
    std::vector<Row> rows =
        compare("decisions",
                scene,
                "",
                asked,
                {1000, session.quick ? 2000 : 400000, session.quick ? 1 : session.repeats});
    rows[0].metric("plans_per_s", 1e6 / rows[0].time_us_p50);
    session.add(std::move(rows));
}

// ---------------------------------------------------------------- fuzzy rules

/// Agents that are evaluated in one frame.
constexpr std::size_t kFuzzyAgents = 4096;

struct FuzzyInputs {
    FuzzyInputs() {
        core::Rng rng(79);
        for (std::size_t i = 0; i < kFuzzyAgents; ++i) {
            distance.push_back(rng.range(0.0F, 40.0F));
            health.push_back(rng.range(0.0F, 1.0F));
        }
    }

    std::vector<float> distance;
    std::vector<float> health;
};

/// The error against the rules in double precision, with the union of terms in 100,000 pieces.
double fuzzy_error(const ai::fuzzy::FuzzyDef& def,
                   const FuzzyInputs& inputs,
                   std::size_t agent,
                   double out) {
    using ai::fuzzy::Term;
    const auto degree = [](const Term& t, double x) {
        const double up = std::isinf(t.a) ? 1.0
                          : t.a == t.b    ? (x >= t.b ? 1.0 : 0.0)
                                          : (x - t.a) / (static_cast<double>(t.b) - t.a);
        const double down = std::isinf(t.d) ? 1.0
                            : t.c == t.d    ? (x <= t.c ? 1.0 : 0.0)
                                            : (t.d - x) / (static_cast<double>(t.d) - t.c);
        return std::clamp(std::min(up, down), 0.0, 1.0);
    };
    const auto& output = def.outputs[0];
    std::vector<double> cut(output.terms.size(), 0.0);
    double weights = 0.0;
    double sum = 0.0;
    for (const auto& rule : def.rules) {
        const double fires =
            std::min(degree(def.inputs[0].terms[rule.when[0].term], inputs.distance[agent]),
                     degree(def.inputs[1].terms[rule.when[1].term], inputs.health[agent]));
        if (output.inference == ai::fuzzy::Inference::kSugeno) {
            weights += fires;
            sum += fires * output.values[rule.then].constant;
        } else {
            cut[rule.then] = std::max(cut[rule.then], fires);
        }
    }
    if (output.inference == ai::fuzzy::Inference::kMamdani) {
        constexpr int kPieces = 100000;
        for (int p = 0; p < kPieces; ++p) {
            const double x = output.low + (p + 0.5) / kPieces * (output.high - output.low);
            double height = 0.0;
            for (std::size_t t = 0; t < cut.size(); ++t) {
                height = std::max(height, std::min(cut[t], degree(output.terms[t], x)));
            }
            weights += height;
            sum += height * x;
        }
    }
    return std::abs(out - sum / weights);
}

class FuzzyTrial : public JudgedTrial {
  public:
    explicit FuzzyTrial(ai::fuzzy::Inference inference)
        : def_(scenario::brave_def(inference)),
          columns_{inputs_.distance.data(), inputs_.health.data()} {}

    void judge(Row& row) override {
        for (std::size_t i = 0; i < kFuzzyAgents; i += 64) {
            row.error = std::max(row.error, fuzzy_error(def_, inputs_, i, result(i)));
        }
        row.error_unit = "-";
        row.metric("rules", static_cast<double>(def_.rules.size()));
    }

  protected:
    [[nodiscard]] virtual double result(std::size_t agent) const = 0;

    ai::fuzzy::FuzzyDef def_;
    FuzzyInputs inputs_;
    std::array<const float*, 2> columns_;
};

class OurFuzzyTrial final : public FuzzyTrial {
  public:
    explicit OurFuzzyTrial(ai::fuzzy::Inference inference)
        : FuzzyTrial(inference),
          system_(def_),
          out_(kFuzzyAgents) {}

    void frame() override {
        for (std::size_t i = 0; i < kFuzzyAgents; ++i) {
            const float in[] = {columns_[0][i], columns_[1][i]};
            system_.evaluate(in, std::span(&out_[i], 1));
        }
    }

  protected:
    [[nodiscard]] double result(std::size_t agent) const override {
        return static_cast<double>(out_[agent]);
    }

  private:
    ai::fuzzy::FuzzySystem system_;
    std::vector<float> out_;
};

class PeerFuzzyTrial final : public FuzzyTrial {
  public:
    explicit PeerFuzzyTrial(ai::fuzzy::Inference inference)
        : FuzzyTrial(inference),
          peer_(def_),
          out_(kFuzzyAgents) {}

    void frame() override {
        for (std::size_t i = 0; i < kFuzzyAgents; ++i) {
            out_[i] = peer_.evaluate(columns_.data(), i);
        }
    }

  protected:
    [[nodiscard]] double result(std::size_t agent) const override { return out_[agent]; }

  private:
    FuzzylitePeer peer_;
    std::vector<double> out_;
};

void run_fuzzy(Session& session, const std::string& scene, ai::fuzzy::Inference inference) {
    const std::vector<Method> asked =
        wanted(session,
               {{"default",
                 "",
                 [inference] {
                     return std::make_unique<OurFuzzyTrial>(inference);
                 }},
                {"default", "fuzzylite", [inference] {
                     return std::make_unique<PeerFuzzyTrial>(inference);
                 }}});
    if (asked.empty()) {
        return;
    }
    std::vector<Row> rows =
        compare("decisions",
                scene,
                "",
                asked,
                {1, session.quick ? 2 : 60, session.quick ? 1 : session.repeats});
    for (Row& row : rows) {
        row.time_us_p50 /= static_cast<double>(kFuzzyAgents);
        row.time_us_p99 /= static_cast<double>(kFuzzyAgents);
        row.metric("evaluations_per_s", 1e6 / row.time_us_p50);
    }
    session.add(std::move(rows));
}

void run_decisions(Session& session) {
    session.note(
        "decisions: one thread. fsm_* and hfsm_*: a tick of 100,000 agents, one by one, six states "
        "with two transitions each (hfsm: eight innermost states in three levels, two transitions "
        "each, so six for an innermost one), one agent in 67 with a reason to leave its state, "
        "ns_per_npc unsorted, ns_per_npc_sorted sorted by state; error: agents whose state differs "
        "from a walk through the definition. goap_*: a plan; error: cost above the cheapest. "
        "fuzzy_*: an evaluation of nine rules; error: from the same rules in double precision. "
        "xor, cartpole: an evaluation of a network; error: what ten seeds miss of all cases, or of "
        "500 steps over 100 "
        "episodes that they never saw, on average. npc_100k: a tick of the agents of a town of a "
        "hundred thousand, a tenth of which players can see, CPU time of the first of two threads; "
        "coarse_share: what one that nobody sees costs in a tick of a whole zone, of one that is "
        "simulated; _day: over a whole day of ten minutes; _busiest: over its 400 ticks with the "
        "most events");
    const auto scene = [&session](const char* name, auto&& run) {
        if (session.wants_scene(name)) {
            session.progress(std::string("decisions ") + name);
            run(name);
        }
    };
    scene("fsm_switch", [&](const char* n) { run_machine(session, n, Form::kSwitch); });
    scene("fsm_pattern", [&](const char* n) { run_machine(session, n, Form::kPattern); });
    scene("fsm_interpreted", [&](const char* n) { run_machine(session, n, Form::kTables); });
    scene("hfsm_interpreted", [&](const char* n) { run_machine(session, n, Form::kLevels); });
    scene("goap_7", [&](const char* n) { run_plan(session, n, true); });
    scene("goap_40_unreachable", [&](const char* n) { run_plan(session, n, false); });
    scene("fuzzy_sugeno",
          [&](const char* n) { run_fuzzy(session, n, ai::fuzzy::Inference::kSugeno); });
    scene("fuzzy_mamdani",
          [&](const char* n) { run_fuzzy(session, n, ai::fuzzy::Inference::kMamdani); });
    scene("xor", [&](const char* n) { run_xor(session, n); });
    scene("cartpole", [&](const char* n) { run_cartpole(session, n); });
    scene("npc_100k", [&](const char* n) { run_npcs(session, n); });
}

const Registration kDecisions({"decisions",
                               "decisions of agents: state machines, plans and fuzzy rules",
                               {"fsm_switch",
                                "fsm_pattern",
                                "fsm_interpreted",
                                "hfsm_interpreted",
                                "goap_7",
                                "goap_40_unreachable",
                                "fuzzy_sugeno",
                                "fuzzy_mamdani",
                                "xor",
                                "cartpole",
                                "npc_100k"},
                               {"default", "neat", "fuzzylite/default"},
                               run_decisions});

}  // namespace

}  // namespace zoned::bench
