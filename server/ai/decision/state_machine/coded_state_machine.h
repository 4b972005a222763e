// CodedTurn: runs state machines that are written as C++ code, with the meaning of compiled tables.
// Reached by no program yet: rules in C++ will use it.
#pragma once

#include "server/ai/decision/state_machine/active_states.h"

#include <algorithm>
#include <array>
#include <span>

namespace zoned::ai::state_machine {

/// The columns of ActiveStates that code writes, and the list for changes.
struct CodedColumns {
    CodedColumns(ActiveStates& states, Tick at, std::vector<StateChange>& to)
        : leaf(states.leaf.data()),
          pending(states.pending.data()),
          pending_since(states.pending_since.data()),
          since(states.since[0].data()),
          now(at),
          changes(to) {}

    /// Kept out of line, because it is rare.
    void change(std::size_t agent, std::uint16_t to, std::uint16_t transition) const;
    /// Counts a held transition whose condition holds now; true once it has held for `hold` ticks.
    [[nodiscard]] bool held(std::size_t agent, std::uint16_t transition, Tick hold) const;

    std::uint16_t* leaf;
    std::uint16_t* pending;
    Tick* pending_since;
    Tick* since;
    Tick now;
    std::vector<StateChange>& changes;
};

/// One agent's decision. Usage, in order of transitions:
///     if (turn.when(distance < 20.0F, kToChase, 9)) { return turn.enter(kChase, kToChase); }
///     ...
///     turn.stay();
class CodedTurn {
  public:
    CodedTurn(const CodedColumns& columns, std::size_t agent) : columns_(columns), agent_(agent) {}

    [[nodiscard]] std::size_t agent() const { return agent_; }

    [[nodiscard]] std::uint16_t state() const { return columns_.leaf[agent_]; }

    /// The time in the state, s, at `dt` s per tick.
    [[nodiscard]] float time_in_state(float dt) const {
        return static_cast<float>(
                   static_cast<std::int32_t>(columns_.now - columns_.since[agent_])) *
               dt;
    }

    /// True if `transition` fires now: it `holds` now and has done so for `hold` ticks.
    bool when(bool holds, std::uint16_t transition, Tick hold = 0) {
        if (!holds) {
            return false;
        }
        if (hold == 0) {
            return true;
        }
        if (pending_ != kNone) {
            return false;
        }
        pending_ = transition;
        return columns_.held(agent_, transition, hold);
    }

    void enter(std::uint16_t state, std::uint16_t transition) {
        columns_.change(agent_, state, transition);
    }

    /// Ends the decision without a transition.
    void stay() { columns_.pending[agent_] = pending_; }

  private:
    const CodedColumns& columns_;
    std::size_t agent_;
    std::uint16_t pending_ = kNone;
};

/// A state as an object. All agents in the state share it, so it holds no data of theirs. Source:
/// Gamma, Helm, Johnson, Vlissides, "Design Patterns", 1994, State.
class CodedState {
  public:
    CodedState() = default;
    CodedState(const CodedState&) = delete;
    CodedState& operator=(const CodedState&) = delete;
    virtual ~CodedState() = default;
    /// One decision of `turn.agent()`: at most one enter(), or stay().
    virtual void decide(CodedTurn& turn, const SenseColumns& senses) const = 0;
};

/// The number of agents that are processed together.
inline constexpr std::size_t kCodedBlock = 256;

/// Orders the agents of a block so that agents in the same state are side by side. The processor
/// then predicts the jump to a state's code for all but the first of them. False where all are in
/// one state; then `order` is not written.
bool group_by_state(const std::uint16_t* leaf,
                    std::size_t count,
                    std::array<std::uint8_t, kCodedBlock>& order);

/// Sorts the changes from `first` on by agent.
void sort_changes(std::vector<StateChange>& changes, std::size_t first);

/// One decision of every agent by `decide(CodedTurn&)`, most often a switch. It is called for one
/// agent at a time, in no particular order. Changes are in order of agents.
template <class Decide>
void step_coded(ActiveStates& states,
                Tick now,
                std::vector<StateChange>& changes,
                Decide&& decide) {
    const CodedColumns columns(states, now, changes);
    const std::size_t count = states.size();
    std::array<std::uint8_t, kCodedBlock> order;  // written before it is read
    for (std::size_t begin = 0; begin < count; begin += kCodedBlock) {
        const std::size_t in = std::min(kCodedBlock, count - begin);
        const std::size_t before = changes.size();
        if (group_by_state(columns.leaf + begin, in, order)) {
            for (std::size_t i = 0; i < in; ++i) {
                CodedTurn turn(columns, begin + order[i]);
                decide(turn);
            }
            sort_changes(changes, before);
        } else {
            for (std::size_t i = 0; i < in; ++i) {
                CodedTurn turn(columns, begin + i);
                decide(turn);
            }
        }
    }
}

/// The same with a class per state: `objects[s]` is state s.
inline void step_coded(ActiveStates& states,
                       std::span<const CodedState* const> objects,
                       const SenseColumns& senses,
                       Tick now,
                       std::vector<StateChange>& changes) {
    step_coded(states, now, changes, [&](CodedTurn& turn) {
        objects[turn.state()]->decide(turn, senses);
    });
}

}  // namespace zoned::ai::state_machine
