// CodedTurn: runs state machines that are written as C++ code, with the meaning of compiled tables.
// Reached by no program yet: rules in C++ will use it.
#pragma once

#include "server/ai/decision/state_machine/active_state.h"

#include <optional>
#include <span>

namespace zoned::ai::state_machine {

/// One agent's decision. Usage, in order of transitions:
///     if (turn.when(distance < 20.0F, kToChase, 9)) { return turn.enter(kChase, kToChase); }
///     ...
///     turn.stay();
/// Code uses one level and no memory.
class CodedTurn {
  public:
    CodedTurn(ActiveState& state, Tick now) : state_(state), now_(now) {}

    [[nodiscard]] std::uint16_t state() const { return state_.leaf; }

    /// The time in the state, s, at `dt` s per tick.
    [[nodiscard]] float time_in_state(float dt) const {
        return static_cast<float>(static_cast<std::int32_t>(now_ - state_.since[0])) * dt;
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
        if (state_.pending != transition) {
            state_.pending = transition;
            state_.pending_since = now_;
            return false;
        }
        return now_ - state_.pending_since >= hold;
    }

    void enter(std::uint16_t state, std::uint16_t transition) {
        change_ = StateChange{0, state_.leaf, state, transition};
        state_.leaf = state;
        state_.since[0] = now_;
        state_.pending = kNone;
    }

    /// Ends the decision without a transition.
    void stay() { state_.pending = pending_; }

    /// The transition that fired.
    [[nodiscard]] const std::optional<StateChange>& change() const { return change_; }

  private:
    ActiveState& state_;
    Tick now_;
    std::uint16_t pending_ = kNone;
    std::optional<StateChange> change_;
};

/// A state as an object. All agents in the state share it, so it holds no data of theirs. Source:
/// Gamma, Helm, Johnson, Vlissides, "Design Patterns", 1994, State.
class CodedState {
  public:
    CodedState() = default;
    CodedState(const CodedState&) = delete;
    CodedState& operator=(const CodedState&) = delete;
    virtual ~CodedState() = default;
    /// One decision: at most one enter(), or stay().
    virtual void decide(CodedTurn& turn, std::span<const float> senses) const = 0;
};

}  // namespace zoned::ai::state_machine
