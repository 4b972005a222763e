#include "server/ai/agent/brain/brain.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace zoned::ai {

namespace {

std::vector<state_machine::StateDef> state_defs(const std::vector<BrainState>& states,
                                                std::uint16_t& leaves) {
    std::vector<state_machine::StateDef> defs;
    for (const BrainState& state : states) {
        state_machine::StateDef def;
        def.name = state.name;
        def.history = state.history;
        for (const Transition& transition : state.transitions) {
            std::vector<Condition> when{transition.first()};
            when.insert(when.end(), transition.also.begin(), transition.also.end());
            def.transitions.push_back({transition.to, std::move(when), transition.hold_s});
        }
        if (state.inside.empty()) {
            def.action = leaves++;
        } else {
            def.inside = state_defs(state.inside, leaves);
        }
        defs.push_back(std::move(def));
    }
    return defs;
}

/// Collects the table's nodes in the order in which states are written, outside in, each with its
/// state. The states of one brain lie side by side, and the states inside them follow.
/// state_machine::compile uses the same numbers.
void collect_nodes(const std::vector<BrainState>& states, std::vector<const BrainState*>& nodes) {
    for (const BrainState& state : states) {
        nodes.push_back(&state);
    }
    for (const BrainState& state : states) {
        if (!state.inside.empty()) {
            collect_nodes(state.inside, nodes);
        }
    }
}

void overlay(const std::vector<VariableChange>& changes, std::vector<float>& per_s) {
    for (const VariableChange& change : changes) {
        if (change.per_s) {
            per_s[change.variable] = *change.per_s;
        }
    }
}

/// Compiles the changes that states and actions make to variables.
void compile_changes(const Brain& brain, float dt, CompiledBrain& out) {
    ZONED_ASSERT(brain.variables.size() <= kMaxVariables, "an agent has few variables");
    std::vector<const BrainState*> nodes;
    collect_nodes(brain.states, nodes);
    ZONED_ASSERT(nodes.size() == out.table.nodes.size(), "every state is a node");
    out.rates.assign(out.states.size() * brain.variables.size(), 0.0F);
    for (std::size_t node = 0; node < nodes.size(); ++node) {
        for (const VariableChange& change : nodes[node]->changes) {
            if (change.on_enter != 0.0F) {
                out.gains.push_back(
                    {static_cast<std::uint16_t>(node), change.variable, change.on_enter});
            }
        }
    }
    // The rate of a leaf comes from the innermost state that sets one. Actions then override the
    // rates of their leaf.
    const std::size_t count = brain.variables.size();
    for (std::uint16_t leaf = 0; leaf < out.table.leaves(); ++leaf) {
        std::vector<float> per_s;
        for (const BrainVariable& variable : brain.variables) {
            per_s.push_back(variable.per_s);
        }
        for (std::size_t level = 0; level < out.table.levels; ++level) {
            const std::uint16_t node = out.table.path[leaf * out.table.levels + level];
            if (node != state_machine::kNone) {
                overlay(nodes[node]->changes, per_s);
            }
        }
        for (std::size_t v = 0; v < count; ++v) {
            out.rates[leaf * count + v] = per_s[v] * dt;
        }
        const CompiledBrain::LeafChoice& choice = out.choices[leaf];
        for (std::size_t d = 0; d < out.states[leaf].actions.size(); ++d) {
            std::vector<float> of_action = per_s;
            overlay(out.states[choice.first + d].changes, of_action);
            for (std::size_t v = 0; v < count; ++v) {
                out.rates[(choice.first + d) * count + v] = of_action[v] * dt;
            }
        }
    }
}

/// Lays out the actions that leaves choose among, after the leaves.
void compile_choices(CompiledBrain& out, float dt) {
    const std::size_t leaves = out.states.size();
    for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
        CompiledBrain::LeafChoice choice;
        choice.first = static_cast<std::uint16_t>(out.states.size());
        const BrainState& state = out.states[leaf];
        if (const auto* by_tree = std::get_if<TreeChoice>(&state.choice)) {
            choice.tree = static_cast<int>(out.trees.size());
            out.trees.emplace_back(by_tree->def, out.senses);
        } else if (const auto* by_plan = std::get_if<PlanChoice>(&state.choice)) {
            choice.plan = static_cast<int>(out.plans.size());
            out.plans.push_back({goap::Actions(by_plan->domain),
                                 by_plan->domain.goals[by_plan->goal].wants,
                                 by_plan->facts});
        } else if (const auto* by_blend = std::get_if<BlendChoice>(&state.choice)) {
            choice.blend = static_cast<int>(out.blends.size());
            const float period =
                static_cast<float>(std::max(1L, std::lround(out.decide_every_s / dt))) * dt;
            out.blends.push_back(
                {fuzzy::FuzzyStateMachine(by_blend->def, period), by_blend->inputs});
        }
        out.choices.push_back(choice);
        const ActionStates actions = state.actions;
        for (const BrainState& action : actions) {
            out.states.push_back(action);
            out.states.back().name = out.states[leaf].name + ":" + action.name;
        }
    }
}

/// Collects the innermost states, in the order in which state_defs() numbers them.
void collect_leaves(const std::vector<BrainState>& states, std::vector<BrainState>& leaves) {
    for (const BrainState& state : states) {
        if (state.inside.empty()) {
            leaves.push_back(state);
            leaves.back().transitions.clear();
        } else {
            collect_leaves(state.inside, leaves);
        }
    }
}

WatchedCondition watch_of(const state_machine::FlatTest& test) {
    return {test.sense,
            test.sign > 0.0F ? Compare::kBelow : Compare::kAbove,
            test.threshold * test.sign};
}

/// Appends a clause. Conditions on stock come last. Conditions on chance come just before them,
/// since a forecast spends the most time on them.
void add_clause(std::vector<WatchedCondition> watches, Clause clause, CompiledBrain& out) {
    const auto stock =
        std::partition(watches.begin(), watches.end(), [&out](const WatchedCondition& w) {
            return !out.is_stock(w.sense);
        });
    std::partition(
        watches.begin(), stock, [](const WatchedCondition& w) { return w.sense != kSenseRandom; });
    clause.first = static_cast<std::uint32_t>(out.watches.size());
    clause.others = static_cast<std::uint16_t>(stock - watches.begin());
    clause.on_stock = static_cast<std::uint16_t>(watches.end() - stock);
    if (clause.on_stock > 0) {
        clause.stock_number = static_cast<std::uint16_t>(
            std::count_if(out.clauses.begin() + out.first_clause.back(),
                          out.clauses.end(),
                          [](const Clause& before) { return before.on_stock > 0; }));
    }
    out.watches.insert(out.watches.end(), watches.begin(), watches.end());
    out.clauses.push_back(clause);
}

void compile_transition_clauses(std::size_t leaf, CompiledBrain& out) {
    const state_machine::FlatStateMachine& table = out.table;
    for (std::size_t k = 0; k < table.width; ++k) {
        const state_machine::FlatTest& test = table.tests[leaf * table.width + k];
        if (test.transition == state_machine::kNone) {
            continue;
        }
        std::vector<WatchedCondition> watches{watch_of(test)};
        const state_machine::FlatTransition& transition = table.transitions[test.transition];
        for (std::size_t c = 0; c < transition.more_count; ++c) {
            watches.push_back(watch_of(table.more[transition.more + c]));
        }
        Clause clause;
        clause.transition = test.transition;
        add_clause(std::move(watches), clause, out);
    }
}

/// Compiles the conditions that leaves depend on: their transitions, and the questions of their
/// trees and plans.
void compile_clauses(CompiledBrain& out) {
    const auto watch = [](const Condition& condition) {
        return WatchedCondition{condition.sense, condition.compare, condition.threshold};
    };
    for (std::size_t leaf = 0; leaf < out.table.leaves(); ++leaf) {
        out.first_clause.push_back(static_cast<std::uint32_t>(out.clauses.size()));
        compile_transition_clauses(leaf, out);
        const BrainState& state = out.states[leaf];
        if (const auto* by_tree = std::get_if<TreeChoice>(&state.choice)) {
            for (const tree::NodeDef& node : by_tree->def.nodes) {
                if (node.yes >= 0 || node.no >= 0) {
                    add_clause({watch(node.test)}, {}, out);
                }
            }
        } else if (const auto* by_plan = std::get_if<PlanChoice>(&state.choice)) {
            for (std::size_t f = 0; f < by_plan->facts.size(); ++f) {
                std::vector<WatchedCondition> watches;
                std::transform(by_plan->facts[f].begin(),
                               by_plan->facts[f].end(),
                               std::back_inserter(watches),
                               watch);
                Clause clause;
                clause.fact = static_cast<std::int16_t>(f);
                add_clause(std::move(watches), clause, out);
            }
        }
    }
    out.first_clause.push_back(static_cast<std::uint32_t>(out.clauses.size()));
}

/// Finds the senses that matter in each leaf. Call it after compile_clauses().
void compile_senses(CompiledBrain& out) {
    const auto bit = [&out](SenseIndex sense) {
        return sense < out.senses ? std::uint64_t{1} << sense : std::uint64_t{0};
    };
    for (std::size_t leaf = 0; leaf < out.table.leaves(); ++leaf) {
        std::uint64_t senses = 0;
        const int blend = out.choices[leaf].blend;
        if (blend >= 0) {
            for (const SenseIndex in : out.blends[static_cast<std::size_t>(blend)].inputs) {
                senses |= bit(in);
            }
        }
        for (const Clause& clause : out.clauses_of(leaf)) {
            for (std::size_t w = 0; w < clause.others + clause.on_stock; ++w) {
                senses |= bit(out.watches[clause.first + w].sense);
            }
        }
        out.senses_of_leaf.push_back(senses);
    }
    out.senses_of_poi = bit(kSenseHomeDistance);
    for (std::size_t k = 0; k < out.points_of_interest.size(); ++k) {
        const auto sense = static_cast<SenseIndex>(out.first_poi_sense + k);
        out.senses_of_poi |= out.is_stock(sense) ? std::uint64_t{0} : bit(sense);
    }
    for (const CompiledBrain::Fuzzy& fuzzy : out.fuzzy) {
        const bool by_place =
            std::any_of(fuzzy.inputs.begin(), fuzzy.inputs.end(), [&](SenseIndex in) {
                return (out.senses_of_poi & bit(in)) != 0;
            });
        for (std::size_t o = 0; o < fuzzy.system.outputs(); ++o) {
            out.senses_of_poi |=
                by_place ? bit(static_cast<SenseIndex>(fuzzy.first + o)) : std::uint64_t{0};
        }
    }
}

}  // namespace

state_machine::StateMachineDef state_machine_of(const Brain& brain) {
    std::uint16_t leaves = 0;
    return {brain.name, state_defs(brain.states, leaves), !brain.coded.empty()};
}

std::size_t senses_of(const Brain& brain) {
    std::size_t senses = kOwnSenses + brain.variables.size();
    for (const FuzzySense& fuzzy : brain.fuzzy) {
        senses += fuzzy.def.outputs.size();
    }
    return senses + brain.points_of_interest.size();
}

CompiledBrain compile(const Brain& brain, float dt) {
    CompiledBrain out;
    out.name = brain.name;
    out.perception_m = brain.perception_m;
    out.decide_every_s = brain.decide_every_s;
    out.perception = brain.perception;
    out.variables = brain.variables;
    out.senses += out.variables.size();
    for (const FuzzySense& fuzzy : brain.fuzzy) {
        out.fuzzy.push_back(
            {fuzzy::FuzzySystem(fuzzy.def), fuzzy.inputs, static_cast<SenseIndex>(out.senses)});
        out.senses += fuzzy.def.outputs.size();
    }
    out.points_of_interest = brain.points_of_interest;
    out.first_poi_sense = out.senses;
    out.senses += out.points_of_interest.size();
    out.table = state_machine::compile(state_machine_of(brain), out.senses, dt);
    std::vector<BrainState> leaves;
    collect_leaves(brain.states, leaves);
    for (std::uint16_t leaf = 0; leaf < out.table.leaves(); ++leaf) {
        out.states.push_back(leaves[out.table.action(leaf)]);
        out.states.back().name = out.table.state_name(leaf);
    }
    compile_choices(out, dt);
    const auto some = [&out](ActionKind action) {
        return std::any_of(out.states.begin(), out.states.end(), [action](const BrainState& state) {
            return state.action == action;
        });
    };
    out.flocks = some(ActionKind::kFlock);
    out.knows_others = out.perception.given || out.flocks;
    out.counts_rivals =
        std::any_of(out.states.begin(), out.states.end(), [](const BrainState& state) {
            return state.rubber_band && state.rubber_band->rivals > 0;
        });
    out.forms_up = some(ActionKind::kFormUp);
    out.forages = some(ActionKind::kForage);
    compile_changes(brain, dt, out);
    compile_clauses(out);
    compile_senses(out);
    return out;
}

}  // namespace zoned::ai
