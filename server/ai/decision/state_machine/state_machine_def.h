// StateMachineDef: a finite state machine as it is written down, states within states, and what is
// wrong with one.
#pragma once

#include "server/ai/decision/senses.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::ai::state_machine {

/// Levels of states within states; 1 is a plain machine.
inline constexpr std::size_t kMaxLevels = 4;
/// States with a memory, in one machine with all that it holds.
inline constexpr std::size_t kMaxMemories = 8;
/// States that hold no others, in one machine with all that it holds.
inline constexpr std::size_t kMaxLeaves = 4096;

/// Transitions of a state together with those of all states that it is inside.
inline constexpr std::size_t kMaxTransitions = 64;

/// Where a state that holds a machine begins when it is entered again (Harel, "Statecharts: a
/// visual formalism for complex systems", Science of Computer Programming 8, 1987, section 2.4).
enum class StateHistory : std::uint8_t {
    kNone,     ///< at the first of its states
    kShallow,  ///< at the one of its states that was last active; that one begins at its own first
    kDeep,     ///< where it was left, all the way down
};

/// Fires when all conditions have held for `hold_s` seconds on end: with two thresholds this is the
/// hysteresis.
struct TransitionDef {
    std::uint16_t to = 0;         ///< index of a state beside the one that it leaves
    std::vector<Condition> when;  ///< at least one
    float hold_s = 0.0F;          ///< s, >= 0
};

struct StateDef {
    std::string name;
    std::uint16_t action = 0;  ///< what it does, for whoever reads the machine's state
    std::vector<TransitionDef> transitions;      ///< tried in order
    std::vector<StateDef> inside;                ///< a machine as a state; begins at the first
    StateHistory history = StateHistory::kNone;  ///< of what is inside
};

struct StateMachineDef {
    std::string name;
    std::vector<StateDef> states;  ///< begins at the first
};

enum class StateMachineDefectKind : std::uint8_t {
    kNoStates,
    kUnknownState,  ///< a transition leads to no state
    kUnreachable,   ///< no transition leads to the state from where its machine begins
    kUnknownSense,  ///< a condition reads what its agents do not sense
    kNoCondition,   ///< a transition without a condition
    kNeverTried,    ///< an earlier transition without hold fires whenever this one could
    kNeverHolds,    ///< two conditions exclude each other
    kTooDeep,       ///< beyond kMaxLevels
    kTooMany,       ///< beyond kMaxLeaves, kMaxMemories or kMaxTransitions
    kIdleMemory,    ///< a history where nothing is inside
};

/// A mistake in a definition and where it lies.
struct StateMachineDefect {
    StateMachineDefectKind kind = StateMachineDefectKind::kNoStates;
    std::vector<std::uint16_t> state;  ///< indices from the outermost machine inwards
    int transition = -1;               ///< of that state; -1: the state itself
    int condition = -1;                ///< of that transition; -1: the transition itself
};

/// All mistakes in `def` for agents with `senses` senses, in order of states. Without any,
/// compile() (flat_machine.h) takes it.
std::vector<StateMachineDefect> defects_of(const StateMachineDef& def, std::size_t senses);

/// What is wrong, for a person: "no transition leads here".
std::string text_of(const StateMachineDefect& defect);

}  // namespace zoned::ai::state_machine
