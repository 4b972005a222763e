// CodedTurn: what machines written as code, as a switch or as a class per state, say their
// conditions through, so that holding and entering mean the same as in tables.
#pragma once

#include "server/ai/fsm/machine_states.h"

#include <span>

namespace zoned::ai::fsm {

/// One mind's decision. Usage, in order of transitions:
///     if (turn.when(distance < 20.0F, kToChase, 9)) { return turn.enter(kChase, kToChase); }
///     ...
///     turn.stay();
class CodedTurn {
  public:
    CodedTurn(MachineStates& states, std::size_t mind, Tick now, std::vector<Change>& changes)
        : states_(states),
          mind_(mind),
          now_(now),
          changes_(changes) {}

    [[nodiscard]] std::size_t mind() const { return mind_; }

    [[nodiscard]] std::uint16_t state() const { return states_.leaf[mind_]; }

    /// Time in the state, s, at `dt` s per tick.
    [[nodiscard]] float time_in_state(float dt) const {
        return static_cast<float>(static_cast<std::int32_t>(now_ - states_.since[0][mind_])) * dt;
    }

    /// Whether `transition` fires now, if it `holds` now and must do so for `hold` ticks.
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
        if (states_.pending[mind_] != transition) {
            states_.pending[mind_] = transition;
            states_.pending_since[mind_] = now_;
            return false;
        }
        return now_ - states_.pending_since[mind_] >= hold;
    }

    void enter(std::uint16_t state, std::uint16_t transition) {
        changes_.push_back({static_cast<std::uint32_t>(mind_), this->state(), state, transition});
        states_.leaf[mind_] = state;
        states_.since[0][mind_] = now_;
        states_.pending[mind_] = kNone;
    }

    /// No transition fired.
    void stay() { states_.pending[mind_] = pending_; }

  private:
    MachineStates& states_;
    std::size_t mind_;
    Tick now_;
    std::vector<Change>& changes_;
    std::uint16_t pending_ = kNone;
};

/// A state as an object (Gamma, Helm, Johnson, Vlissides, "Design Patterns", 1994, State): shared
/// by all minds that are in it, so it holds nothing of theirs.
class CodedState {
  public:
    CodedState() = default;
    CodedState(const CodedState&) = delete;
    CodedState& operator=(const CodedState&) = delete;
    virtual ~CodedState() = default;
    /// One decision of `turn.mind()`: at most one enter(), or stay().
    virtual void decide(CodedTurn& turn, const SenseColumns& senses) const = 0;
};

/// One decision of every mind. `decide(CodedTurn&)` makes it, most often by a switch.
template <class Decide>
void step_coded(MachineStates& states, Tick now, std::vector<Change>& changes, Decide&& decide) {
    for (std::size_t i = 0; i < states.size(); ++i) {
        CodedTurn turn(states, i, now, changes);
        decide(turn);
    }
}

/// The same with a class per state: `objects[s]` is state s.
inline void step_coded(MachineStates& states,
                       std::span<const CodedState* const> objects,
                       const SenseColumns& senses,
                       Tick now,
                       std::vector<Change>& changes) {
    step_coded(states, now, changes, [&](CodedTurn& turn) {
        objects[turn.state()]->decide(turn, senses);
    });
}

}  // namespace zoned::ai::fsm
