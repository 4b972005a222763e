// CodedMachine: a state machine that is written as C++ code, with the meaning of compiled tables.
#pragma once

#include "server/ai/decision/state_machine/active_state.h"
#include "shared/core/assert.h"
#include "shared/core/result.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::state_machine {

/// One agent's decision. States and transitions have the numbers of their CodedMachine. Usage, in
/// order of transitions:
///     if (turn.when(distance < 20.0F, kToChase, 0.3F)) { return turn.enter(kChase, kToChase); }
///     ...
/// A decision that ends without enter() stays in its state. Code uses one level and no memory.
class CodedTurn {
  public:
    /// `state`: the number that the code gives to `memory.leaf`. `dt` in s per tick.
    CodedTurn(ActiveState& memory, std::uint16_t state, Tick now, float dt)
        : memory_(memory),
          state_(state),
          now_(now),
          dt_(dt) {}

    [[nodiscard]] std::uint16_t state() const { return state_; }

    /// The time in the state, s.
    [[nodiscard]] float time_in_state() const { return seconds_since(memory_.since[0]); }

    /// True if `transition` fires now: it `holds` now and has done so for `hold_s` s on end. With a
    /// hold, of several that hold the first one counts, as in step().
    bool when(bool holds, std::uint16_t transition, float hold_s = 0.0F) {
        if (!holds) {
            return false;
        }
        if (!(hold_s > 0.0F)) {
            return true;
        }
        if (pending_ != kNone) {
            return false;
        }
        pending_ = transition;
        if (memory_.pending != transition) {
            memory_.pending = transition;
            memory_.pending_since = now_;
            return false;
        }
        // Equals hold_ticks(): a product of floats grows with the number of ticks.
        return seconds_since(memory_.pending_since) >= hold_s;
    }

    /// Goes to `state` by `transition`. Once a decision.
    void enter(std::uint16_t state, std::uint16_t transition) {
        ZONED_ASSERT(!entered_, "a decision enters one state");
        entered_ = {state, transition};
    }

  private:
    friend class BoundMachine;

    struct EnteredState {
        std::uint16_t state = 0;
        std::uint16_t transition = 0;
    };

    /// Stores the hold, if there is one. The state that was entered, if any, is left for the
    /// caller.
    std::optional<EnteredState> end() {
        memory_.pending = entered_ ? kNone : pending_;
        return entered_;
    }

    [[nodiscard]] float seconds_since(Tick since) const {
        return static_cast<float>(static_cast<std::int32_t>(now_ - since)) * dt_;
    }

    ActiveState& memory_;
    std::uint16_t state_;
    std::uint16_t pending_ = kNone;
    Tick now_;
    float dt_;
    std::optional<EnteredState> entered_;
};

/// A state as an object. All agents in the state share it, so it holds no data of theirs. Source:
/// Gamma, Helm, Johnson, Vlissides, "Design Patterns", 1994, State.
class CodedState {
  public:
    CodedState() = default;
    CodedState(const CodedState&) = delete;
    CodedState& operator=(const CodedState&) = delete;
    virtual ~CodedState() = default;
    /// One decision: at most one enter().
    virtual void decide(CodedTurn& turn, std::span<const float> senses) const = 0;
};

/// One decision in any state: a switch over turn.state(), say.
using CodedDecision = void (*)(CodedTurn& turn, std::span<const float> senses);

/// Has one of `decision` and `objects`. The code depends on its turn and its senses alone: no
/// clock, no chance of its own, no globals, or replays will differ. It runs on several threads.
struct CodedMachine {
    std::string name;
    std::vector<std::string> states;       ///< by number
    std::vector<std::string> senses;       ///< as the code gets them, side by side
    std::vector<std::string> transitions;  ///< by number, for people who ask why
    CodedDecision decision = nullptr;
    std::vector<std::shared_ptr<const CodedState>> objects{};  ///< by state
};

using CodedMachines = std::vector<CodedMachine>;

/// A coded machine whose names are resolved for one brain.
class BoundMachine {
  public:
    /// `leaves` and `senses`: the names that agents have, by leaf and by sense; `dt` in s. Fails
    /// where a state is on one side alone, a sense is missing, or the machine is incomplete.
    static core::Result<BoundMachine> bind(const CodedMachine& machine,
                                           std::span<const std::string> leaves,
                                           std::span<const std::string> senses,
                                           float dt);

    /// One decision of an agent that senses `values`, by SenseIndex; returns the transition that
    /// fired. StateChange::agent is left for the caller.
    std::optional<StateChange> decide(ActiveState& state,
                                      std::span<const float> values,
                                      Tick now) const;

    [[nodiscard]] const std::string& name() const { return name_; }

    /// The senses that the code reads.
    [[nodiscard]] std::span<const SenseIndex> senses() const { return senses_; }

    /// Names by number.
    [[nodiscard]] std::span<const std::string> transitions() const { return transitions_; }

  private:
    BoundMachine() = default;

    std::string name_;
    CodedDecision decision_ = nullptr;
    std::vector<std::shared_ptr<const CodedState>> objects_;
    std::vector<SenseIndex> senses_;
    std::vector<std::uint16_t> leaf_of_;   ///< by the code's number of a state
    std::vector<std::uint16_t> state_of_;  ///< by leaf
    std::vector<std::string> transitions_;
    float dt_ = 0.0F;
};

}  // namespace zoned::ai::state_machine
