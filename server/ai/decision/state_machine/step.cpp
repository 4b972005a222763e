// build: hot loops
#include "server/ai/decision/state_machine/flat_state_machine.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <bit>
#include <optional>

namespace zoned::ai::state_machine {

namespace {

/// The inputs of an agent: its senses, then its times in its states.
using Inputs = std::array<float, kMaxSenses + kMaxLevels>;  // written where it is read

bool test_holds(const FlatTest& test, const Inputs& inputs) {
    return inputs[test.sense] * test.sign < test.threshold;
}

/// Time in a state, s. 32 bits hold 100 days of ticks, and lanes of them become floats at once.
float time_since(Tick since, Tick now, float dt) {
    return static_cast<float>(static_cast<std::int32_t>(now - since)) * dt;
}

/// Takes an agent through a transition.
class Walker {
  public:
    Walker(const FlatStateMachine& machine, ActiveState& state, const Inputs& inputs, Tick now)
        : machine_(machine),
          state_(state),
          inputs_(inputs),
          now_(now) {}

    /// `mask`: whose first conditions hold, bit by test of the agent's leaf.
    std::optional<StateChange> turn(std::uint64_t mask) {
        const FlatTest* tests = &machine_.tests[state_.leaf * machine_.width];
        std::uint16_t pending = kNone;
        for (; mask != 0; mask &= mask - 1) {
            const std::uint16_t number =
                tests[static_cast<std::size_t>(std::countr_zero(mask))].transition;
            const FlatTransition& transition = machine_.transitions[number];
            if (!rest_holds(transition)) {
                continue;
            }
            if (transition.hold == 0) {
                return fire(number, pending);
            }
            if (pending != kNone) {
                continue;
            }
            pending = number;
            if (state_.pending != number) {
                state_.pending = number;
                state_.pending_since = now_;
            } else if (now_ - state_.pending_since >= transition.hold) {
                return fire(number, kNone);
            }
        }
        state_.pending = pending;
        return std::nullopt;
    }

  private:
    [[nodiscard]] bool rest_holds(const FlatTransition& transition) const {
        for (std::size_t c = 0; c < transition.more_count; ++c) {
            if (!test_holds(machine_.more[transition.more + c], inputs_)) {
                return false;
            }
        }
        return true;
    }

    /// `pending`: the transition that is being held besides. It goes on where it belongs to a state
    /// that is not left.
    StateChange fire(std::uint16_t number, std::uint16_t pending) {
        const FlatTransition& transition = machine_.transitions[number];
        const std::uint16_t from = state_.leaf;
        if (machine_.memories > 0) {
            remember(from, transition.level);
        }
        const std::uint16_t to = transition.leaf != kNone ? transition.leaf : recall(transition.to);
        state_.leaf = to;
        for (std::size_t level = transition.level; level < machine_.levels; ++level) {
            state_.since[level] = now_;
        }
        const bool stays =
            pending != kNone && machine_.transitions[pending].level < transition.level;
        state_.pending = stays ? pending : kNone;
        return {0, from, to, number};
    }

    void remember(std::uint16_t leaf, std::size_t level) {
        const std::uint16_t* path = &machine_.path[leaf * machine_.levels];
        for (; level < machine_.levels && path[level] != kNone; ++level) {
            const FlatNode& node = machine_.nodes[path[level]];
            if (node.memory != kNone) {
                state_.memory[node.memory] = node.history == StateHistory::kDeep
                                                 ? machine_.leaf_node[leaf]
                                                 : path[level + 1];
            }
        }
    }

    [[nodiscard]] std::uint16_t recall(std::uint16_t at) const {
        while (machine_.nodes[at].first != kNone) {
            const FlatNode& node = machine_.nodes[at];
            const std::uint16_t last = node.memory == kNone ? kNone : state_.memory[node.memory];
            at = last == kNone ? node.first : last;
        }
        return machine_.nodes[at].leaf;
    }

    const FlatStateMachine& machine_;
    ActiveState& state_;
    const Inputs& inputs_;
    Tick now_;
};

}  // namespace

std::optional<StateChange> step(const FlatStateMachine& machine,
                                ActiveState& state,
                                std::span<const float> values,
                                Tick now) {
    ZONED_ASSERT(values.size() >= machine.senses, "an agent senses what its machine reads");
    Inputs inputs;
    std::copy_n(values.begin(), machine.senses, inputs.begin());
    for (std::size_t level = 0; level < machine.levels; ++level) {
        inputs[machine.senses + level] = time_since(state.since[level], now, machine.dt);
    }
    const FlatTest* const row = &machine.tests[state.leaf * machine.width];
    std::uint64_t mask = 0;
    for (std::size_t k = 0; k < machine.width; ++k) {
        mask |= static_cast<std::uint64_t>(test_holds(row[k], inputs)) << k;
    }
    if (mask == 0 && state.pending == kNone) {
        return std::nullopt;
    }
    return Walker(machine, state, inputs, now).turn(mask);
}

}  // namespace zoned::ai::state_machine
