#include "server/ai/agent/decision.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

void add(Agent& agent, const CompiledBrain& brain, std::size_t variable, float amount) {
    const BrainVariable& of = brain.variables[variable];
    agent.variables[variable] = std::clamp(agent.variables[variable] + amount, of.low, of.high);
}

/// Makes the changes to variables of the entered states from `level` on.
void gain(Agent& agent, const CompiledBrain& brain, std::size_t level) {
    const state_machine::FlatStateMachine& table = brain.table;
    const std::uint16_t* path = &table.path[agent.state_machine.leaf * table.levels];
    for (const CompiledBrain::Gain& gain : brain.gains) {
        const std::size_t at = table.nodes[gain.node].level;
        if (at >= level && path[at] == gain.node) {
            add(agent, brain, gain.variable, gain.amount);
        }
    }
}

using Known = std::span<const float>;

bool all_hold(const std::vector<Condition>& conditions, Known senses) {
    return std::all_of(conditions.begin(), conditions.end(), [senses](const Condition& condition) {
        return holds(condition, senses[condition.sense]);
    });
}

/// The first action of a plan, or `otherwise`.
std::uint16_t planned_action(Agent& agent,
                             const CompiledBrain::Plans& plans,
                             std::uint16_t first,
                             std::uint16_t otherwise,
                             Known senses,
                             DecisionScratch& scratch) {
    goap::FactSet facts = 0;
    for (std::size_t f = 0; f < plans.facts.size(); ++f) {
        facts |= static_cast<goap::FactSet>(all_hold(plans.facts[f], senses)) << f;
    }
    if (facts == agent.facts) {
        return agent.current_action;
    }
    agent.facts = facts;
    if (!scratch.planner || scratch.planner->bound() != scratch.max_plan_nodes) {
        scratch.planner.emplace(scratch.max_plan_nodes);
    }
    scratch.planner->plan(plans.actions, facts, plans.goal, scratch.plan);
    ++scratch.plans;
    switch (scratch.plan.verdict) {
        case goap::Verdict::kPlanned:
            return scratch.plan.size > 0
                       ? static_cast<std::uint16_t>(first + scratch.plan.action[0])
                       : otherwise;
        case goap::Verdict::kUnreachable:
            ++scratch.plans_unreachable;
            break;
        case goap::Verdict::kCutOff:
            ++scratch.plans_cut_off;
            break;
    }
    return otherwise;
}

/// Updates the degrees of a blend's states. Returns the action of the most active state; of equal
/// states, the first.
std::uint16_t blended_action(Agent& agent,
                             const CompiledBrain::Blend& blend,
                             std::uint16_t first,
                             bool entered,
                             Known senses) {
    if (entered) {
        agent.degrees[0] = 1.0F;
    }
    std::array<float, fuzzy::kMaxInputs> in{};
    for (std::size_t k = 0; k < blend.inputs.size(); ++k) {
        in[k] = senses[blend.inputs[k]];
    }
    const std::span<float> degrees(agent.degrees.data(), blend.brain.states());
    blend.brain.step(std::span<const float>(in.data(), blend.inputs.size()), degrees);
    const auto most = std::max_element(degrees.begin(), degrees.end());
    return static_cast<std::uint16_t>(first + (most - degrees.begin()));
}

/// Chooses the action of the state. `entered`: the state was entered just now.
void choose(Agent& agent,
            const CompiledBrain& brain,
            bool entered,
            Known senses,
            Tick now,
            DecisionScratch& scratch) {
    const std::uint16_t leaf = agent.state_machine.leaf;
    const CompiledBrain::LeafChoice& choice = brain.choices[leaf];
    if (entered) {
        agent.facts = kUnplanned;
        agent.degrees = {};
    }
    std::uint16_t action = leaf;
    if (choice.tree >= 0) {
        action = static_cast<std::uint16_t>(
            choice.first + brain.trees[static_cast<std::size_t>(choice.tree)].decide(senses));
    } else if (choice.plan >= 0) {
        action = planned_action(agent,
                                brain.plans[static_cast<std::size_t>(choice.plan)],
                                choice.first,
                                leaf,
                                senses,
                                scratch);
    }
    if (choice.blend >= 0) {
        action = blended_action(agent,
                                brain.blends[static_cast<std::size_t>(choice.blend)],
                                choice.first,
                                entered || agent.current_action == leaf,
                                senses);
    }
    if (action == agent.current_action && !entered) {
        return;
    }
    grow(agent, brain, now);
    // All actions of a blend go on, whichever is the most active.
    agent.entered = agent.entered || entered || choice.blend < 0 || agent.current_action == leaf;
    agent.current_action = action;
    if (action != leaf) {
        for (const VariableChange& change : brain.states[action].changes) {
            add(agent, brain, change.variable, change.on_enter);
        }
    }
}

}  // namespace

void take_notice(Agent& agent, const Percept& percept, const CompiledBrain& brain, Tick now) {
    agent.prey = percept.prey;
    if (!brain.perception.given) {
        return;
    }
    agent.ward = percept.ward;
    agent.noticed = percept.noticed;
    if (percept.prey && percept.noticed) {
        agent.known = percept.place;
        agent.known_at = now;
    }
}

void begin(Agent& agent, const CompiledBrain& brain, Tick now) {
    agent.state_machine = state_machine::ActiveState(now);
    agent.current_action = 0;
    agent.wants = all_trades(brain.states[0]);
    agent.facts = kUnplanned;
    agent.degrees = {};
    for (std::size_t v = 0; v < brain.variables.size(); ++v) {
        agent.variables[v] = brain.variables[v].start;
    }
    agent.variables_at = now;
    gain(agent, brain, 0);
}

float variable_at(const Agent& agent, const CompiledBrain& brain, std::size_t v, Tick now) {
    const BrainVariable& of = brain.variables[v];
    const float rate = brain.rates[agent.current_action * brain.variables.size() + v];
    const auto ticks = static_cast<float>(now - agent.variables_at);
    return std::clamp(agent.variables[v] + rate * ticks, of.low, of.high);
}

void grow(Agent& agent, const CompiledBrain& brain, Tick now) {
    for (std::size_t v = 0; v < brain.variables.size(); ++v) {
        agent.variables[v] = variable_at(agent, brain, v, now);
    }
    agent.variables_at = now;
}

float drawn_at(const Agent& agent, Tick now) {
    const std::uint64_t bits =
        core::mix(agent.rng.stream ^ core::mix(static_cast<std::uint64_t>(now)));
    return static_cast<float>(bits >> 40U) * 0x1.0p-24F;
}

void sense(const Agent& agent,
           const CompiledBrain& brain,
           const Percept& percept,
           const Vec2& here,
           const PointsOfInterest& points_of_interest,
           Tick now,
           Senses& senses,
           std::uint64_t wanted) {
    senses[kSensePlayerDistance] = percept.distance;
    senses[kSenseHomeDistance] = (here - Vec2(agent.home.x(), agent.home.z())).norm();
    senses[kSenseTimeOfDay] = points_of_interest.time_of_day(now);
    senses[kSenseRandom] = drawn_at(agent, now);
    senses[kSenseConfidence] = percept.confidence;
    senses[kSenseAllies] = percept.allies;
    senses[kSenseFoes] = percept.foes;
    senses[kSenseLeads] = leads(brain, percept.ward) ? 1.0F : 0.0F;
    for (std::size_t v = 0; v < brain.variables.size(); ++v) {
        senses[kOwnSenses + v] = variable_at(agent, brain, v, now);
    }
    sense_more(agent, brain, here, points_of_interest, now, senses, wanted);
}

void sense_more(const Agent& agent,
                const CompiledBrain& brain,
                const Vec2& here,
                const PointsOfInterest& points_of_interest,
                Tick now,
                Senses& senses,
                std::uint64_t wanted) {
    for (const CompiledBrain::Fuzzy& fuzzy : brain.fuzzy) {
        const std::uint64_t outputs = ~std::uint64_t{0} >> (64U - fuzzy.system.outputs());
        if ((wanted >> fuzzy.first & outputs) == 0) {
            continue;
        }
        std::array<float, fuzzy::kMaxInputs> in;  // written where they are read
        for (std::size_t k = 0; k < fuzzy.inputs.size(); ++k) {
            in[k] = senses[fuzzy.inputs[k]];
        }
        fuzzy.system.evaluate(std::span(in.data(), fuzzy.inputs.size()),
                              std::span(&senses[fuzzy.first], fuzzy.system.outputs()));
    }
    for (std::size_t k = 0; k < brain.points_of_interest.size(); ++k) {
        if ((wanted >> (brain.first_poi_sense + k) & 1U) == 0) {
            continue;
        }
        const PointOfInterestSense& of = brain.points_of_interest[k];
        senses[brain.first_poi_sense + k] =
            of.stock < 0
                ? (here - points_of_interest.spot(of.place, agent.entity)).norm()
                : points_of_interest.stock(of.place, static_cast<std::size_t>(of.stock), now);
    }
}

bool decide(Agent& agent,
            const CompiledBrain& brain,
            const Percept& percept,
            const Vec2& here,
            const PointsOfInterest& points_of_interest,
            Tick now,
            DecisionScratch& scratch) {
    Senses senses;
    const std::uint64_t wanted = brain.senses_of_leaf[agent.state_machine.leaf];
    sense(agent, brain, percept, here, points_of_interest, now, senses, wanted);
    take_notice(agent, percept, brain, now);
    agent.far = percept.player_far;
    agent.fresh = true;
    const Known known(senses.data(), brain.senses);
    const std::optional<state_machine::StateChange> change =
        brain.code ? brain.code->decide(agent.state_machine, known, now)
                   : state_machine::step(brain.table, agent.state_machine, known, now);
    if (change) {
        const std::uint64_t then = brain.senses_of_leaf[agent.state_machine.leaf];
        sense_more(agent, brain, here, points_of_interest, now, senses, then & ~wanted);
        grow(agent, brain, now);
        gain(agent, brain, brain.table.transitions[change->transition].level);
    }
    scratch.change = change;
    choose(agent, brain, change.has_value(), known, now, scratch);
    return change.has_value();
}

bool able(const Agent& agent, const CompiledBrain& brain, const Trade& trade, Tick now) {
    return std::all_of(trade.items.begin(), trade.items.end(), [&](const TradeItem& item) {
        const float then = variable_at(agent, brain, item.variable, now) + item.amount;
        const BrainVariable& of = brain.variables[item.variable];
        return then >= of.low && then <= of.high;
    });
}

std::uint8_t all_trades(const BrainState& state) {
    return static_cast<std::uint8_t>((1U << state.trades.size()) - 1U);
}

TradeResult settle_trades(Agent& agent,
                          const CompiledBrain& brain,
                          const Vec2& here,
                          PointsOfInterest& points_of_interest,
                          Tick now) {
    const std::vector<Trade>& trades = brain.states[agent.current_action].trades;
    TradeResult result;
    for (std::size_t t = 0; t < trades.size(); ++t) {
        const unsigned bit = 1U << t;
        if ((agent.wants & bit) == 0 ||
            points_of_interest.outside(trades[t].place, here) > kAtPointM) {
            continue;
        }
        if (!able(agent, brain, trades[t], now) || !points_of_interest.can(trades[t], now)) {
            ++result.refused;
            continue;
        }
        grow(agent, brain, now);
        for (const TradeItem& item : trades[t].items) {
            agent.variables[item.variable] += item.amount;
        }
        points_of_interest.commit(trades[t], now);
        agent.wants = static_cast<std::uint8_t>(agent.wants & ~bit);
        ++result.done;
    }
    return result;
}

Tick decision_period(const CompiledBrain& brain, float dt) {
    return std::max<Tick>(1, std::lround(brain.decide_every_s / dt));
}

Tick next_decision(EntityId entity, Tick period, Tick now) {
    const Tick earliest = now + 1;
    const Tick after = (earliest - static_cast<Tick>(entity.value)) % period;
    return earliest + (after > 0 ? period - after : -after);
}

}  // namespace zoned::ai
