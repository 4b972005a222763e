#include "server/ai/machine.h"

namespace zoned::ai {

namespace {

std::vector<fsm::StateDef> state_defs(const std::vector<State>& states, std::uint16_t& leaves) {
    std::vector<fsm::StateDef> defs;
    for (const State& state : states) {
        fsm::StateDef def;
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

/// Innermost states, in the order in which state_defs() numbers them.
void collect_leaves(const std::vector<State>& states, std::vector<State>& leaves) {
    for (const State& state : states) {
        if (state.inside.empty()) {
            leaves.push_back(state);
            leaves.back().transitions.clear();
        } else {
            collect_leaves(state.inside, leaves);
        }
    }
}

}  // namespace

fsm::MachineDef definition_of(const Machine& machine) {
    std::uint16_t leaves = 0;
    return {machine.name, state_defs(machine.states, leaves)};
}

std::size_t senses_of(const Machine& machine) {
    std::size_t senses = kOwnSenses;
    for (const FuzzySense& fuzzy : machine.fuzzy) {
        senses += fuzzy.def.outputs.size();
    }
    return senses;
}

CompiledMachine compile(const Machine& machine, float dt) {
    CompiledMachine out;
    out.name = machine.name;
    out.perception_m = machine.perception_m;
    out.decide_every_s = machine.decide_every_s;
    for (const FuzzySense& fuzzy : machine.fuzzy) {
        out.fuzzy.push_back({fuzzy::FuzzySystem(fuzzy.def),
                             fuzzy.inputs,
                             static_cast<SenseIndex>(out.senses)});
        out.senses += fuzzy.def.outputs.size();
    }
    out.table = fsm::compile(definition_of(machine), out.senses, dt);
    std::vector<State> leaves;
    collect_leaves(machine.states, leaves);
    for (std::uint16_t leaf = 0; leaf < out.table.leaves(); ++leaf) {
        out.states.push_back(leaves[out.table.action(leaf)]);
        out.states.back().name = out.table.state_name(leaf);
    }
    return out;
}

}  // namespace zoned::ai
