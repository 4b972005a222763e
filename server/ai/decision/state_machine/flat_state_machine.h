// FlatStateMachine: a state machine compiled to tables, and the step of an agent through it.
#pragma once

#include "server/ai/decision/state_machine/active_state.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::state_machine {

/// The most senses that a state machine can read.
inline constexpr std::size_t kMaxSenses = 64;

/// The first condition of a transition, in the form value * sign < threshold, so that both
/// comparisons become one.
struct FlatTest {
    float threshold = -1.0F;
    float sign = 0.0F;     ///< 1, -1, or 0: an unused place, which never holds
    SenseIndex sense = 0;  ///< beyond the senses: time in the state at level (sense - senses)
    std::uint16_t transition = kNone;
};

struct FlatTransition {
    Tick hold = 0;                 ///< ticks
    std::uint16_t to = 0;          ///< node
    std::uint16_t leaf = 0;        ///< the leaf where the transition ends, or kNone where that
                                   ///< depends on a memory
    std::uint16_t level = 0;       ///< level of the state that it leaves, outermost 0
    std::uint16_t more = 0;        ///< further conditions, in FlatStateMachine::more
    std::uint16_t more_count = 0;  ///< number of further conditions
};

/// A state of any level.
struct FlatNode {
    std::string name;  ///< with the names of the states around it: "combat/attack"
    std::uint16_t parent = kNone;
    std::uint16_t level = 0;
    std::uint16_t first = kNone;   ///< its first inner state; kNone: it has none
    std::uint16_t memory = kNone;  ///< column of its history
    StateHistory history = StateHistory::kNone;
    std::uint16_t leaf = kNone;  ///< its number among the innermost states (leaves)
    std::uint16_t action = 0;
};

/// The tests of a leaf stand side by side, those of the outermost state first. So an alarm of an
/// outer state comes before the transitions of the states inside. Source for that order in
/// STATEMATE: Harel and Naamad, "The STATEMATE semantics of statecharts", TOSEM 5, 1996, section 4.
/// All leaves have `width` tests; tests that never hold fill up the rest. So agents in different
/// states take the same path through the code.
struct FlatStateMachine {
    std::string name;
    std::size_t senses = 0;
    std::size_t levels = 1;
    std::size_t memories = 0;
    std::size_t width = 2;                    ///< tests per leaf, even
    float dt = 0.0F;                          ///< s per tick
    std::vector<FlatTest> tests;              ///< width x leaves
    std::vector<FlatTransition> transitions;  ///< by number
    std::vector<FlatTest> more;               ///< further conditions of transitions
    std::vector<FlatNode> nodes;
    std::vector<std::uint16_t> leaf_node;  ///< node of each leaf
    std::vector<std::uint16_t> path;       ///< levels x leaves: nodes from the outermost in
    std::array<bool, kMaxLevels> timed{};  ///< levels whose time a condition reads

    [[nodiscard]] std::size_t leaves() const { return leaf_node.size(); }

    [[nodiscard]] std::uint16_t action(std::uint16_t leaf) const {
        return nodes[leaf_node[leaf]].action;
    }

    [[nodiscard]] const std::string& state_name(std::uint16_t leaf) const {
        return nodes[leaf_node[leaf]].name;
    }
};

/// Ticks of `dt` s after which a condition has held for `hold_s`: the least n with n dt >= hold_s
/// in floats. 0 where hold_s is not above 0.
Tick hold_ticks(float hold_s, float dt);

/// `def` must have no defects for `senses` senses (at most kMaxSenses); `dt` in s, > 0.
FlatStateMachine compile(const StateMachineDef& def, std::size_t senses, float dt);

/// One decision of an agent that senses `values`, the state machine's senses; returns the
/// transition that fired. Of the transitions of its state, outermost first, the first one fires
/// that has held long enough. The first transition in order that holds but must hold longer is
/// stored as pending. A transition without hold fires at once, wherever it stands. A transition of
/// an inner state leaves the hold of an outer one alone. StateChange::agent is left for the caller.
std::optional<StateChange> step(const FlatStateMachine& machine,
                                ActiveState& state,
                                std::span<const float> values,
                                Tick now);

}  // namespace zoned::ai::state_machine
