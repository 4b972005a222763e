#include "server/ai/decision/state_machine/flat_state_machine.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai::state_machine {

namespace {

/// Numbers the states, then writes the tables.
class Compiler {
  public:
    Compiler(const StateMachineDef& def, std::size_t senses, float dt) {
        machine_.name = def.name;
        machine_.senses = senses;
        machine_.dt = dt;
        add_states(def.states, kNone, 0, "");
        add_transitions(def.states, 0);
        lay_out_tests();
        ZONED_ASSERT(descend(0) == 0, "agents begin in leaf 0");
    }

    FlatStateMachine take() { return std::move(machine_); }

  private:
    /// The states of one state machine stand side by side; their inner states come behind them all.
    void add_states(const std::vector<StateDef>& states,
                    std::uint16_t parent,
                    std::uint16_t level,
                    const std::string& prefix) {
        machine_.levels = std::max<std::size_t>(machine_.levels, level + 1U);
        const std::size_t first = machine_.nodes.size();
        for (const StateDef& state : states) {
            FlatNode node;
            node.name = prefix + state.name;
            node.parent = parent;
            node.level = level;
            node.action = state.action;
            node.history = state.history;
            machine_.nodes.push_back(std::move(node));
            tests_of_.emplace_back();
        }
        if (parent != kNone) {
            machine_.nodes[parent].first = static_cast<std::uint16_t>(first);
        }
        for (std::size_t s = 0; s < states.size(); ++s) {
            const auto at = static_cast<std::uint16_t>(first + s);
            if (states[s].inside.empty()) {
                machine_.nodes[at].leaf = static_cast<std::uint16_t>(machine_.leaf_node.size());
                machine_.leaf_node.push_back(at);
                continue;
            }
            if (states[s].history != StateHistory::kNone) {
                machine_.nodes[at].memory = static_cast<std::uint16_t>(machine_.memories++);
            }
            add_states(states[s].inside,
                       at,
                       static_cast<std::uint16_t>(level + 1),
                       machine_.nodes[at].name + "/");
        }
    }

    void add_transitions(const std::vector<StateDef>& states, std::uint16_t first) {
        for (std::size_t s = 0; s < states.size(); ++s) {
            const auto at = static_cast<std::uint16_t>(first + s);
            for (const TransitionDef& transition : states[s].transitions) {
                add_transition(at, static_cast<std::uint16_t>(first + transition.to), transition);
            }
            if (!states[s].inside.empty()) {
                add_transitions(states[s].inside, machine_.nodes[at].first);
            }
        }
    }

    void add_transition(std::uint16_t from, std::uint16_t to, const TransitionDef& def) {
        FlatTransition flat;
        flat.hold = hold_ticks(def.hold_s, machine_.dt);
        flat.to = to;
        flat.leaf = remembers(to) ? kNone : descend(to);
        flat.level = machine_.nodes[from].level;
        flat.more = static_cast<std::uint16_t>(machine_.more.size());
        flat.more_count = static_cast<std::uint16_t>(def.when.size() - 1);
        const auto number = static_cast<std::uint16_t>(machine_.transitions.size());
        for (std::size_t c = 0; c < def.when.size(); ++c) {
            const FlatTest test = test_of(def.when[c], flat.level, number);
            (c == 0 ? tests_of_[from] : machine_.more).push_back(test);
        }
        machine_.transitions.push_back(flat);
    }

    FlatTest test_of(const Condition& condition, std::uint16_t level, std::uint16_t transition) {
        FlatTest test;
        test.sign = condition.compare == Compare::kBelow ? 1.0F : -1.0F;
        test.threshold = condition.threshold * test.sign;
        test.sense = condition.sense;
        if (condition.sense == kStateTime) {
            test.sense = static_cast<SenseIndex>(machine_.senses + level);
            machine_.timed[level] = true;
        }
        test.transition = transition;
        return test;
    }

    /// True if the leaf that an entry into `node` reaches depends on a memory.
    [[nodiscard]] bool remembers(std::uint16_t node) const {
        for (; node != kNone; node = machine_.nodes[node].first) {
            if (machine_.nodes[node].memory != kNone) {
                return true;
            }
        }
        return false;
    }

    [[nodiscard]] std::uint16_t descend(std::uint16_t node) const {
        while (machine_.nodes[node].first != kNone) {
            node = machine_.nodes[node].first;
        }
        return machine_.nodes[node].leaf;
    }

    void lay_out_tests() {
        const std::size_t leaves = machine_.leaves();
        machine_.path.assign(machine_.levels * leaves, kNone);
        std::vector<std::vector<FlatTest>> rows(leaves);
        for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
            for (std::uint16_t node = machine_.leaf_node[leaf]; node != kNone;
                 node = machine_.nodes[node].parent) {
                machine_.path[leaf * machine_.levels + machine_.nodes[node].level] = node;
                rows[leaf].insert(
                    rows[leaf].begin(), tests_of_[node].begin(), tests_of_[node].end());
            }
            machine_.width = std::max(machine_.width, (rows[leaf].size() + 1) / 2 * 2);
        }
        for (std::vector<FlatTest>& row : rows) {
            row.resize(machine_.width);
            machine_.tests.insert(machine_.tests.end(), row.begin(), row.end());
        }
    }

    FlatStateMachine machine_;
    std::vector<std::vector<FlatTest>> tests_of_;  ///< by node
};

}  // namespace

Tick hold_ticks(float hold_s, float dt) {
    if (hold_s <= 0.0F) {
        return 0;
    }
    auto ticks = std::max<Tick>(1, static_cast<Tick>(std::floor(hold_s / dt)) - 1);
    while (static_cast<float>(ticks) * dt < hold_s) {
        ++ticks;
    }
    return ticks;
}

FlatStateMachine compile(const StateMachineDef& def, std::size_t senses, float dt) {
    ZONED_ASSERT(senses <= kMaxSenses && dt > 0.0F, "a machine has senses and a time step");
    ZONED_ASSERT(defects_of(def, senses).empty(), "a machine without defects is compiled");
    return Compiler(def, senses, dt).take();
}

}  // namespace zoned::ai::state_machine
