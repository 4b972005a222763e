#include "server/ai/agent/hot_reload_migration.h"

#include "server/ai/agent/decision.h"

#include <algorithm>

namespace zoned::ai {

namespace {

std::uint16_t node_of(const state_machine::FlatStateMachine& table, const std::string& name) {
    for (std::size_t n = 0; n < table.nodes.size(); ++n) {
        if (table.nodes[n].name == name) {
            return static_cast<std::uint16_t>(n);
        }
    }
    return state_machine::kNone;
}

/// The state `leaf` of `after`, with the memory of `from`. All levels that both state paths share
/// keep their times.
state_machine::ActiveState carry_state(const state_machine::ActiveState& from,
                                       const state_machine::FlatStateMachine& before,
                                       const state_machine::FlatStateMachine& after,
                                       std::uint16_t leaf,
                                       Tick now) {
    state_machine::ActiveState to(now);
    to.leaf = leaf;
    to.since = from.since;
    const std::uint16_t* old_path = &before.path[from.leaf * before.levels];
    const std::uint16_t* path = &after.path[leaf * after.levels];
    for (std::size_t level = 0; level < after.levels; ++level) {
        const bool was = level < before.levels && old_path[level] != state_machine::kNone;
        if (path[level] != state_machine::kNone && !was) {
            to.since[level] = now;
        }
    }
    for (const state_machine::FlatNode& node : after.nodes) {
        const std::uint16_t old =
            node.memory == state_machine::kNone ? state_machine::kNone : node_of(before, node.name);
        if (old == state_machine::kNone || before.nodes[old].memory == state_machine::kNone ||
            before.nodes[old].history != node.history) {
            continue;
        }
        const std::uint16_t place = from.memory[before.nodes[old].memory];
        if (place != state_machine::kNone) {
            to.memory[node.memory] = node_of(after, before.nodes[place].name);
        }
    }
    return to;
}

bool same_pace(const BrainState& a, const BrainState& b) {
    return a.speed_factor == b.speed_factor && a.sprint == b.sprint;
}

/// Carries variables over by name. `entered`: the first state was entered, and its changes to
/// variables stay.
void carry_variables(const Agent& from,
                     const CompiledBrain& before,
                     const CompiledBrain& after,
                     bool entered,
                     Agent& to) {
    for (std::size_t v = 0; v < after.variables.size(); ++v) {
        const BrainVariable& variable = after.variables[v];
        const float given = entered ? to.variables[v] - variable.start : 0.0F;
        to.variables[v] = variable.start + given;
        for (std::size_t old = 0; old < before.variables.size(); ++old) {
            if (before.variables[old].name == variable.name) {
                to.variables[v] =
                    std::clamp(from.variables[old] + given, variable.low, variable.high);
            }
        }
    }
}

}  // namespace

void migrate(Agent& agent,
             const CompiledBrain& before,
             const CompiledBrain& after,
             std::uint16_t index,
             Tick now,
             float dt) {
    grow(agent, before, now);
    const Agent old = agent;
    begin(agent, after, now);
    agent.brain = index;
    agent.entered = true;
    agent.fresh = true;
    const std::uint16_t node =
        node_of(after.table, before.table.state_name(old.state_machine.leaf));
    const std::uint16_t leaf =
        node == state_machine::kNone ? state_machine::kNone : after.table.nodes[node].leaf;
    carry_variables(old, before, after, leaf == state_machine::kNone, agent);
    if (leaf != state_machine::kNone) {
        agent.state_machine = carry_state(old.state_machine, before.table, after.table, leaf, now);
        agent.current_action = leaf;
        const BrainState& did = before.states[old.current_action];
        for (std::size_t d = 0; d < after.states.size(); ++d) {
            const bool of_leaf =
                d == leaf || (d >= after.choices[leaf].first &&
                              d < after.choices[leaf].first + after.states[leaf].actions.size());
            if (of_leaf && after.states[d].name == did.name) {
                agent.current_action = static_cast<std::uint16_t>(d);
                // An unchanged action goes on where it is.
                agent.entered = old.entered || after.states[d].action != did.action;
                if (!same_pace(after.states[d], did)) {
                    agent.timed = false;  // its segment ends at another time
                    agent.next_steering = now;
                }
                agent.degrees = {};
                if (after.choices[leaf].blend >= 0 && d != leaf) {
                    agent.degrees[d - after.choices[leaf].first] = 1.0F;  // only the most active
                }
            }
        }
    }
    if (old.next_decision > now) {
        agent.next_decision = next_decision(agent.entity, decision_period(after, dt), now);
    }
}

}  // namespace zoned::ai
