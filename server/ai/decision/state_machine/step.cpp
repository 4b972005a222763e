// build: hot loops
#include "server/ai/decision/state_machine/flat_state_machine.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <bit>
#include <optional>

namespace zoned::ai::state_machine {

namespace {

/// The number of agents processed together. Their times in state are first written down as one more
/// column.
constexpr std::size_t kBlock = 256;

/// Block: the inputs of a block of agents.
struct Block {
    std::array<const float*, kMaxSenses + kMaxLevels> column{};
    std::array<std::array<float, kBlock>, kMaxLevels> time;  // written where it is read

    [[nodiscard]] float value(SenseIndex sense, std::size_t i) const { return column[sense][i]; }
};

/// OneRead: the inputs of one agent.
struct OneRead {
    std::array<float, kMaxSenses + kMaxLevels> values;  // written where it is read

    [[nodiscard]] float value(SenseIndex sense, std::size_t /*i*/) const { return values[sense]; }
};

/// Takes the change of one agent.
struct OneChange {
    std::optional<StateChange> change;

    void push_back(const StateChange& taken) { change = taken; }
};

template <class Read>
bool test_holds(const FlatTest& test, const Read& read, std::size_t i) {
    return read.value(test.sense, i) * test.sign < test.threshold;
}

/// Time in a state, s. 32 bits hold 100 days of ticks, and lanes of them become floats at once.
float time_since(Tick since, Tick now, float dt) {
    return static_cast<float>(static_cast<std::int32_t>(now - since)) * dt;
}

/// Takes one agent through a transition.
template <class States, class Changes>
class Walker {
  public:
    Walker(const FlatStateMachine& machine, States& states, Tick now, Changes& to)
        : machine_(machine),
          states_(states),
          now_(now),
          changes_(to) {}

    /// `mask`: whose first conditions hold, bit by test of the agent's leaf.
    template <class Read>
    void turn(std::size_t agent, std::uint64_t mask, const Read& block, std::size_t in_block) {
        const FlatTest* tests = &machine_.tests[states_.leaf[agent] * machine_.width];
        std::uint16_t pending = kNone;
        for (; mask != 0; mask &= mask - 1) {
            const std::uint16_t number =
                tests[static_cast<std::size_t>(std::countr_zero(mask))].transition;
            const FlatTransition& transition = machine_.transitions[number];
            if (!rest_holds(transition, block, in_block)) {
                continue;
            }
            if (transition.hold == 0) {
                fire(agent, number, pending);
                return;
            }
            if (pending != kNone) {
                continue;
            }
            pending = number;
            if (states_.pending[agent] != number) {
                states_.pending[agent] = number;
                states_.pending_since[agent] = now_;
            } else if (now_ - states_.pending_since[agent] >= transition.hold) {
                fire(agent, number, kNone);
                return;
            }
        }
        states_.pending[agent] = pending;
    }

  private:
    template <class Read>
    [[nodiscard]] bool rest_holds(const FlatTransition& transition,
                                  const Read& block,
                                  std::size_t in_block) const {
        for (std::size_t c = 0; c < transition.more_count; ++c) {
            if (!test_holds(machine_.more[transition.more + c], block, in_block)) {
                return false;
            }
        }
        return true;
    }

    /// `pending`: the transition that is being held besides. It goes on where it belongs to a state
    /// that is not left.
    void fire(std::size_t agent, std::uint16_t number, std::uint16_t pending) {
        const FlatTransition& transition = machine_.transitions[number];
        const std::uint16_t from = states_.leaf[agent];
        if (machine_.memories > 0) {
            remember(agent, from, transition.level);
        }
        const std::uint16_t to =
            transition.leaf != kNone ? transition.leaf : recall(agent, transition.to);
        states_.leaf[agent] = to;
        for (std::size_t level = transition.level; level < machine_.levels; ++level) {
            states_.since[level][agent] = now_;
        }
        const bool stays =
            pending != kNone && machine_.transitions[pending].level < transition.level;
        states_.pending[agent] = stays ? pending : kNone;
        changes_.push_back({static_cast<std::uint32_t>(agent), from, to, number});
    }

    void remember(std::size_t agent, std::uint16_t leaf, std::size_t level) {
        const std::uint16_t* path = &machine_.path[leaf * machine_.levels];
        for (; level < machine_.levels && path[level] != kNone; ++level) {
            const FlatNode& node = machine_.nodes[path[level]];
            if (node.memory != kNone) {
                states_.memory[node.memory][agent] = node.history == StateHistory::kDeep
                                                         ? machine_.leaf_node[leaf]
                                                         : path[level + 1];
            }
        }
    }

    [[nodiscard]] std::uint16_t recall(std::size_t agent, std::uint16_t at) const {
        while (machine_.nodes[at].first != kNone) {
            const FlatNode& node = machine_.nodes[at];
            const std::uint16_t last =
                node.memory == kNone ? kNone : states_.memory[node.memory][agent];
            at = last == kNone ? node.first : last;
        }
        return machine_.nodes[at].leaf;
    }

    const FlatStateMachine& machine_;
    States& states_;
    Tick now_;
    Changes& changes_;
};

/// Reads the columns of a block from `begin` on.
void read_block(const FlatStateMachine& machine,
                const ActiveStates& states,
                const SenseColumns& senses,
                Tick now,
                std::size_t begin,
                std::size_t count,
                Block& block) {
    for (std::size_t k = 0; k < machine.senses; ++k) {
        block.column[k] = senses.column[k] + begin;
    }
    for (std::size_t level = 0; level < machine.levels; ++level) {
        block.column[machine.senses + level] = block.time[level].data();
        if (!machine.timed[level]) {
            continue;
        }
        const Tick* since = &states.since[level][begin];
        for (std::size_t i = 0; i < count; ++i) {
            block.time[level][i] = time_since(since[i], now, machine.dt);
        }
    }
}

/// Computes `Width` tests of each agent, without a branch; 0: as many as the state machine has.
template <std::size_t Width>
void update_agents(const FlatStateMachine& machine,
                   ActiveStates& states,
                   const SenseColumns& senses,
                   Tick now,
                   std::vector<StateChange>& changes) {
    Walker walker(machine, states, now, changes);
    Block block;
    const std::size_t width = Width == 0 ? machine.width : Width;
    const FlatTest* const tests = machine.tests.data();
    const std::size_t count = states.size();
    for (std::size_t begin = 0; begin < count; begin += kBlock) {
        const std::size_t in = std::min(kBlock, count - begin);
        read_block(machine, states, senses, now, begin, in, block);
        const std::uint16_t* const leaf = &states.leaf[begin];
        const std::uint16_t* const pending = &states.pending[begin];
        for (std::size_t i = 0; i < in; ++i) {
            const FlatTest* const row = tests + leaf[i] * width;
            std::uint64_t mask = 0;
            for (std::size_t k = 0; k < width; ++k) {
                mask |= static_cast<std::uint64_t>(test_holds(row[k], block, i)) << k;
            }
            if (mask != 0 || pending[i] != kNone) {
                walker.turn(begin + i, mask, block, i);
            }
        }
    }
}

}  // namespace

void step(const FlatStateMachine& machine,
          ActiveStates& states,
          const SenseColumns& senses,
          Tick now,
          std::vector<StateChange>& changes) {
    ZONED_ASSERT(senses.column.size() >= machine.senses && senses.count == states.size(),
                 "agents sense what their machine reads");
    switch (machine.width) {
        case 2:
            return update_agents<2>(machine, states, senses, now, changes);
        case 4:
            return update_agents<4>(machine, states, senses, now, changes);
        case 6:
            return update_agents<6>(machine, states, senses, now, changes);
        case 8:
            return update_agents<8>(machine, states, senses, now, changes);
        default:
            return update_agents<0>(machine, states, senses, now, changes);
    }
}

std::optional<StateChange> step_one(const FlatStateMachine& machine,
                                    ActiveState& state,
                                    std::span<const float> values,
                                    Tick now) {
    ZONED_ASSERT(values.size() >= machine.senses, "an agent senses what its machine reads");
    OneRead read;
    std::copy_n(values.begin(), machine.senses, read.values.begin());
    for (std::size_t level = 0; level < machine.levels; ++level) {
        read.values[machine.senses + level] = time_since(state.since[level][0], now, machine.dt);
    }
    const FlatTest* const row = &machine.tests[state.leaf[0] * machine.width];
    std::uint64_t mask = 0;
    for (std::size_t k = 0; k < machine.width; ++k) {
        mask |= static_cast<std::uint64_t>(test_holds(row[k], read, 0)) << k;
    }
    OneChange change;
    if (mask != 0 || state.pending[0] != kNone) {
        Walker(machine, state, now, change).turn(0, mask, read, 0);
    }
    return change.change;
}

}  // namespace zoned::ai::state_machine
