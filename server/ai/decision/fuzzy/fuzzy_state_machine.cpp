// build: hot loops
#include "server/ai/decision/fuzzy/fuzzy_state_machine.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai::fuzzy {

FuzzyStateMachine::FuzzyStateMachine(const FuzzyStateMachineDef& def, float dt)
    : states_(def.states.size()) {
    ZONED_ASSERT(states_ >= 1 && states_ <= kMaxFuzzyStates && def.inputs.size() <= kMaxInputs,
                 "a fuzzy machine has few states and inputs");
    if (def.response_s > 0.0F) {
        most_per_step_ = std::min(1.0F, dt / def.response_s);
    }
    for (const FuzzyVariable& variable : def.inputs) {
        inputs_.push_back({variable.low,
                           variable.high,
                           static_cast<std::uint16_t>(terms_.size()),
                           static_cast<std::uint16_t>(variable.terms.size())});
        for (const Term& term : variable.terms) {
            terms_.push_back(flat(term));
        }
    }
    ZONED_ASSERT(terms_.size() <= kMaxTerms, "a fuzzy machine has few terms");
    for (const FuzzyTransition& transition : def.transitions) {
        ZONED_ASSERT(
            transition.from < states_ && transition.to < states_ && !transition.when.empty(),
            "a transition leads from a state to another when something is so");
        transitions_.push_back({transition.from,
                                transition.to,
                                static_cast<std::uint16_t>(propositions_.size()),
                                static_cast<std::uint16_t>(transition.when.size()),
                                transition.any});
        for (const Proposition& p : transition.when) {
            ZONED_ASSERT(known(p, def.inputs), "a proposition speaks of what exists");
            propositions_.push_back(
                {static_cast<std::uint16_t>(inputs_[p.variable].first + p.term), p.negated});
        }
    }
}

void FuzzyStateMachine::step(std::span<const float> values, std::span<float> degrees) const {
    ZONED_ASSERT(values.size() == inputs_.size() && degrees.size() == states_,
                 "a value for each input, a degree for each state");
    std::array<float, kMaxTerms> terms;  // written where they are read
    for (std::size_t k = 0; k < inputs_.size(); ++k) {
        const StateMachineInput& input = inputs_[k];
        const float x = clamped(values[k], input.low, input.high);
        for (std::size_t t = input.first; t < input.first + std::size_t{input.count}; ++t) {
            terms[t] = degree(terms_[t], x);
        }
    }
    std::array<float, kMaxFuzzyStates> leaves{};  // the largest degree of a transition out
    std::array<float, kMaxFuzzyStates> comes{};
    for (const FlatFuzzyTransition& transition : transitions_) {
        const StateMachineProposition* p = &propositions_[transition.first];
        float fires = transition.any ? 0.0F : 1.0F;
        for (std::size_t k = 0; k < transition.count; ++k, ++p) {
            const float is = p->negated ? 1.0F - terms[p->term] : terms[p->term];
            fires = transition.any ? std::max(fires, is) : std::min(fires, is);
        }
        leaves[transition.from] = std::max(leaves[transition.from], fires);
        comes[transition.to] =
            std::max(comes[transition.to], std::min(degrees[transition.from], fires));
    }
    // min(d, 1 - c) and min(d, c) cannot both be 0 where d is not.
    float largest = 1e-30F;
    for (std::size_t s = 0; s < states_; ++s) {
        comes[s] = std::max(comes[s], std::min(degrees[s], 1.0F - leaves[s]));
        largest = std::max(largest, comes[s]);
    }
    for (std::size_t s = 0; s < states_; ++s) {
        const float to = comes[s] / largest;
        degrees[s] =
            std::max(std::min(to, degrees[s] + most_per_step_), degrees[s] - most_per_step_);
    }
}

}  // namespace zoned::ai::fuzzy
