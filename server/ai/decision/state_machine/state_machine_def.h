// StateMachineDef: the definition of a hierarchical state machine, and the check for its defects.
#pragma once

#include "server/ai/decision/senses.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::ai::state_machine {

/// The most levels of states within states; 1 is a plain state machine.
inline constexpr std::size_t kMaxLevels = 4;
/// The most states with a memory, in one state machine with all that it contains.
inline constexpr std::size_t kMaxMemories = 8;
/// The most innermost states, in one state machine with all that it contains.
inline constexpr std::size_t kMaxLeaves = 4096;

/// The most transitions of a state together with those of all states around it.
inline constexpr std::size_t kMaxTransitions = 64;

/// The state in which a state with inner states begins when it is entered again. Source: Harel,
/// "Statecharts: a visual formalism for complex systems", Science of Computer Programming 8, 1987,
/// section 2.4.
enum class StateHistory : std::uint8_t {
    kNone,     ///< at the first of its states
    kShallow,  ///< at its inner state that was last active, which begins at its own first
    kDeep,     ///< at the inner state that was last active, on all levels down
};

/// Fires when all conditions have held for `hold_s` seconds without a break. With two thresholds
/// this gives hysteresis.
struct TransitionDef {
    std::uint16_t to = 0;         ///< index of a state on the same level as the one that it leaves
    std::vector<Condition> when;  ///< at least one
    float hold_s = 0.0F;          ///< s, >= 0
};

struct StateDef {
    std::string name;
    std::uint16_t action = 0;  ///< the state's action, for the reader of the active state
    std::vector<TransitionDef> transitions;      ///< tried in order
    std::vector<StateDef> inside;                ///< inner states, a state machine of their own;
                                                 ///< begins at the first
    StateHistory history = StateHistory::kNone;  ///< history of the inner states
};

struct StateMachineDef {
    std::string name;
    std::vector<StateDef> states;  ///< begins at the first
    bool coded = false;            ///< code leads from state to state: CodedMachine
};

enum class StateMachineDefectKind : std::uint8_t {
    kNoStates,
    kUnknownState,  ///< a transition leads to no state
    kUnreachable,   ///< no transition leads to the state from where its state machine begins
    kUnknownSense,  ///< a condition reads a sense that its agents do not have
    kNoCondition,   ///< a transition without a condition
    kNeverTried,    ///< an earlier transition without hold fires whenever this one could
    kNeverHolds,    ///< two conditions exclude each other
    kTooDeep,       ///< beyond kMaxLevels
    kTooMany,       ///< beyond kMaxLeaves, kMaxMemories or kMaxTransitions
    kIdleMemory,    ///< a history without inner states
};

/// StateMachineDefect: a mistake in a definition and its position.
struct StateMachineDefect {
    StateMachineDefectKind kind = StateMachineDefectKind::kNoStates;
    std::vector<std::uint16_t> state;  ///< indices from the outermost state machine inwards
    int transition = -1;               ///< transition of that state; -1: the state itself
    int condition = -1;                ///< condition of that transition; -1: the transition itself
};

/// All mistakes in `def` for agents with `senses` senses, in order of states. compile()
/// (flat_state_machine.h) accepts a definition without any.
std::vector<StateMachineDefect> defects_of(const StateMachineDef& def, std::size_t senses);

/// The defect as a sentence for people: "no transition leads here".
std::string text_of(const StateMachineDefect& defect);

}  // namespace zoned::ai::state_machine
