// FuzzyStateMachine: a state machine with several states active to a degree.
#pragma once

#include "server/ai/decision/fuzzy/membership.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::fuzzy {

inline constexpr std::size_t kMaxFuzzyStates = 16;

/// Fires to the smallest degree of its propositions, or to the largest where `any` is set.
struct FuzzyTransition {
    std::uint16_t from = 0;
    std::uint16_t to = 0;
    std::vector<Proposition> when;
    bool any = false;
};

struct FuzzyStateMachineDef {
    std::string name;
    std::vector<FuzzyVariable> inputs;
    std::vector<std::string> states;  ///< names; agents begin in the first state alone
    std::vector<FuzzyTransition> transitions;
    float response_s = 0.0F;  ///< s in which a degree can go from 0 to 1; 0: at once
};

/// Each state has a degree d and each transition a degree c. A state keeps min(d, 1 - c) for the
/// largest c of the transitions that leave it. It gets min(d of the source state, c) from each
/// transition that leads to it. The larger of both counts. Source for max-min composition of a
/// fuzzy automaton: Wee and Fu, "A formulation of fuzzy automata and its application as a model of
/// learning systems", IEEE Transactions on Systems Science and Cybernetics 5, 1969.
/// Then all degrees are scaled so that the largest is 1; max-min alone would let activity fade
/// away. Each degree moves to its new value by at most dt / response_s.
class FuzzyStateMachine {
  public:
    /// `def` must have inputs without defects, except kGap and kOutside. It must have 1 to
    /// kMaxFuzzyStates states. Transitions lead between states that exist, with propositions that
    /// exist. `dt` in s, > 0.
    FuzzyStateMachine(const FuzzyStateMachineDef& def, float dt);

    [[nodiscard]] std::size_t states() const { return states_; }

    [[nodiscard]] std::size_t inputs() const { return inputs_.size(); }

    /// One step of an agent: a value for each input, a degree for each state.
    void step(std::span<const float> values, std::span<float> degrees) const;

  private:
    struct StateMachineInput {
        float low = 0.0F;
        float high = 1.0F;
        std::uint16_t first = 0;
        std::uint16_t count = 0;
    };

    struct FlatFuzzyTransition {
        std::uint16_t from = 0;
        std::uint16_t to = 0;
        std::uint16_t first = 0;  ///< index of the first of its propositions
        std::uint16_t count = 0;
        bool any = false;
    };

    struct StateMachineProposition {
        std::uint16_t term = 0;
        bool negated = false;
    };

    std::size_t states_;
    float most_per_step_ = 1.0F;
    std::vector<StateMachineInput> inputs_;
    std::vector<FlatTerm> terms_;
    std::vector<FlatFuzzyTransition> transitions_;
    std::vector<StateMachineProposition> propositions_;
};

}  // namespace zoned::ai::fuzzy
