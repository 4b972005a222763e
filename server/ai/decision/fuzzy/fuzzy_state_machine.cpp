// build: hot loops
#include "server/ai/decision/fuzzy/fuzzy_state_machine.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai::fuzzy {

namespace {

/// Eight numbers of a column from `at` on, or as many as there are.
Lanes load(const float* column, std::size_t at, std::size_t count) {
    if (at + kLanes <= count) {
        return Eigen::Map<const Lanes>(column + at);
    }
    Lanes lanes = Lanes::Constant(column[at]);
    for (std::size_t lane = 1; at + lane < count; ++lane) {
        lanes[static_cast<Eigen::Index>(lane)] = column[at + lane];
    }
    return lanes;
}

void store(const Lanes& lanes, float* column, std::size_t at, std::size_t count) {
    if (at + kLanes <= count) {
        Eigen::Map<Lanes>(column + at) = lanes;
        return;
    }
    for (std::size_t lane = 0; at + lane < count; ++lane) {
        column[at + lane] = lanes[static_cast<Eigen::Index>(lane)];
    }
}

}  // namespace

void FuzzyDegrees::reset(std::size_t states, std::size_t count) {
    for (std::size_t s = 0; s < states; ++s) {
        degree[s].assign(count, s == 0 ? 1.0F : 0.0F);
    }
}

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
    wants_.resize(def.states[0].outputs.size());
    for (const FuzzyState& state : def.states) {
        ZONED_ASSERT(state.outputs.size() == wants_.size(), "all states want something of all");
        for (std::size_t o = 0; o < wants_.size(); ++o) {
            wants_[o].push_back(state.outputs[o]);
        }
    }
}

void FuzzyStateMachine::step(std::span<const float* const> in,
                             std::size_t count,
                             FuzzyDegrees& degrees) const {
    ZONED_ASSERT(in.size() == inputs_.size(), "a column for each input");
    std::array<Lanes, kMaxInputs> values;
    States states;
    for (std::size_t i = 0; i < count; i += kLanes) {
        for (std::size_t k = 0; k < in.size(); ++k) {
            values[k] = load(in[k], i, count);
        }
        for (std::size_t s = 0; s < states_; ++s) {
            states[s] = load(degrees.degree[s].data(), i, count);
        }
        step_lanes(values, states);
        for (std::size_t s = 0; s < states_; ++s) {
            store(states[s], degrees.degree[s].data(), i, count);
        }
    }
}

void FuzzyStateMachine::step_one(std::span<const float> values, std::span<float> degrees) const {
    ZONED_ASSERT(values.size() == inputs_.size() && degrees.size() == states_,
                 "a value for each input, a degree for each state");
    std::array<Lanes, kMaxInputs> in;
    States states;
    for (std::size_t k = 0; k < values.size(); ++k) {
        in[k] = Lanes::Constant(values[k]);
    }
    for (std::size_t s = 0; s < states_; ++s) {
        states[s] = Lanes::Constant(degrees[s]);
    }
    step_lanes(in, states);
    for (std::size_t s = 0; s < states_; ++s) {
        degrees[s] = states[s][0];
    }
}

void FuzzyStateMachine::step_lanes(const std::array<Lanes, kMaxInputs>& in, States& degrees) const {
    std::array<Lanes, kMaxTerms> terms;
    for (std::size_t k = 0; k < inputs_.size(); ++k) {
        const StateMachineInput& input = inputs_[k];
        const Lanes x = clamped(in[k], input.low, input.high);
        for (std::size_t t = input.first; t < input.first + std::size_t{input.count}; ++t) {
            terms[t] = degree(terms_[t], x);
        }
    }
    States leaves;  // the largest degree of a transition out of the state
    States comes;
    for (std::size_t s = 0; s < states_; ++s) {
        leaves[s].setZero();
        comes[s].setZero();
    }
    for (const FlatFuzzyTransition& transition : transitions_) {
        const StateMachineProposition* p = &propositions_[transition.first];
        Lanes fires = Lanes::Constant(transition.any ? 0.0F : 1.0F);
        for (std::size_t k = 0; k < transition.count; ++k, ++p) {
            const Lanes is = p->negated ? Lanes(1.0F - terms[p->term]) : terms[p->term];
            fires = transition.any ? Lanes(fires.max(is)) : Lanes(fires.min(is));
        }
        leaves[transition.from] = leaves[transition.from].max(fires);
        comes[transition.to] = comes[transition.to].max(degrees[transition.from].min(fires));
    }
    Lanes largest = Lanes::Zero();
    for (std::size_t s = 0; s < states_; ++s) {
        comes[s] = comes[s].max(degrees[s].min(1.0F - leaves[s]));
        largest = largest.max(comes[s]);
    }
    // min(d, 1 - c) and min(d, c) cannot both be 0 where d is not.
    largest = largest.max(1e-30F);
    for (std::size_t s = 0; s < states_; ++s) {
        const Lanes to = comes[s] / largest;
        degrees[s] = to.min(degrees[s] + most_per_step_).max(degrees[s] - most_per_step_);
    }
}

void FuzzyStateMachine::blend(const FuzzyDegrees& degrees,
                              std::size_t count,
                              std::span<float* const> out) const {
    ZONED_ASSERT(out.size() == wants_.size(), "a column for each output");
    for (std::size_t i = 0; i < count; i += kLanes) {
        States states;
        Lanes weights = Lanes::Zero();
        for (std::size_t s = 0; s < states_; ++s) {
            states[s] = load(degrees.degree[s].data(), i, count);
            weights += states[s];
        }
        for (std::size_t o = 0; o < wants_.size(); ++o) {
            Lanes sum = Lanes::Zero();
            for (std::size_t s = 0; s < states_; ++s) {
                sum += states[s] * wants_[o][s];
            }
            store(sum / weights, out[o], i, count);
        }
    }
}

}  // namespace zoned::ai::fuzzy
