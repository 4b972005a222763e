// build: hot loops
#include "server/ai/decision/fuzzy/fuzzy_system.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai::fuzzy {

FuzzySystem::FuzzySystem(const FuzzyDef& def) {
    ZONED_ASSERT(def.inputs.size() <= kMaxInputs && def.outputs.size() <= kMaxOutputs,
                 "a fuzzy system has few inputs and outputs");
    for (const FuzzyVariable& variable : def.inputs) {
        inputs_.push_back({variable.low,
                           variable.high,
                           static_cast<std::uint16_t>(terms_.size()),
                           static_cast<std::uint16_t>(variable.terms.size())});
        for (const Term& term : variable.terms) {
            terms_.push_back(flat(term));
        }
    }
    ZONED_ASSERT(terms_.size() <= kMaxTerms, "a fuzzy system has few terms");
    for (std::size_t o = 0; o < def.outputs.size(); ++o) {
        add_output(def, o);
    }
}

void FuzzySystem::add_output(const FuzzyDef& def, std::size_t index) {
    const FuzzyOutput& output = def.outputs[index];
    FlatOutput flat;
    flat.inference = output.inference;
    flat.low = output.low;
    flat.high = output.high;
    flat.otherwise = output.otherwise;
    flat.first_rule = static_cast<std::uint16_t>(rules_.size());
    flat.terms = static_cast<std::uint16_t>(output.terms.size());
    ZONED_ASSERT(flat.terms <= kMaxOutputTerms, "an output has few terms");
    for (std::size_t r = 0; r < def.rules.size(); ++r) {
        const Rule& rule = def.rules[r];
        if (rule.output != index) {
            continue;
        }
        rules_.push_back({static_cast<std::uint16_t>(propositions_.size()),
                          static_cast<std::uint16_t>(rule.when.size()),
                          rule.any,
                          rule.weight,
                          rule.then});
        rule_number_.push_back(static_cast<std::uint16_t>(r));
        for (const Proposition& p : rule.when) {
            ZONED_ASSERT(known(p, def.inputs), "a proposition speaks of what exists");
            propositions_.push_back({static_cast<std::uint16_t>(inputs_[p.variable].first + p.term),
                                     p.negated ? -1.0F : 1.0F,
                                     p.negated ? 1.0F : 0.0F});
        }
        ++flat.rules;
    }
    for (const Linear& value : output.values) {
        flat.linear.push_back(value.constant);
        for (std::size_t i = 0; i < inputs_.size(); ++i) {
            const float factor = i < value.of_input.size() ? value.of_input[i] : 0.0F;
            flat.linear.push_back(factor);
            flat.constant = flat.constant && factor == 0.0F;
        }
    }
    if (output.inference == Inference::kMamdani) {
        lay_out_samples(output, flat);
    }
    outputs_.push_back(std::move(flat));
}

void FuzzySystem::lay_out_samples(const FuzzyOutput& output, FlatOutput& to) const {
    to.samples = output.samples;
    const float piece = (output.high - output.low) / static_cast<float>(output.samples);
    for (std::size_t s = 0; s < output.samples; ++s) {
        const float at = output.low + (static_cast<float>(s) + 0.5F) * piece;
        to.first_term.push_back(static_cast<std::uint32_t>(to.sample_terms.size()));
        to.position.push_back(at);
        for (std::size_t t = 0; t < output.terms.size(); ++t) {
            const float degree_here = degree(flat(output.terms[t]), at);
            if (degree_here > 0.0F) {
                to.sample_terms.push_back({static_cast<std::uint16_t>(t), degree_here});
            }
        }
    }
    to.first_term.push_back(static_cast<std::uint32_t>(to.sample_terms.size()));
}

void FuzzySystem::fuzzify(std::span<const float> in, Inputs& within, Degrees& degrees) const {
    for (std::size_t k = 0; k < inputs_.size(); ++k) {
        const SystemInput& input = inputs_[k];
        within[k] = clamped(in[k], input.low, input.high);
        for (std::size_t t = input.first; t < input.first + std::size_t{input.count}; ++t) {
            degrees[t] = degree(terms_[t], within[k]);
        }
    }
}

void FuzzySystem::evaluate(std::span<const float> in, std::span<float> out) const {
    ZONED_ASSERT(in.size() == inputs_.size() && out.size() == outputs_.size(),
                 "a place for each input and output");
    Inputs within;
    Degrees degrees;
    fuzzify(in, within, degrees);
    for (std::size_t o = 0; o < outputs_.size(); ++o) {
        const FlatOutput& output = outputs_[o];
        const float value = output.inference == Inference::kSugeno ? sugeno(output, within, degrees)
                                                                   : mamdani(output, degrees);
        out[o] = clamped(value, output.low, output.high);
    }
}

float FuzzySystem::fire(const FlatRule& rule, const Degrees& degrees) const {
    const FlatProposition* p = &propositions_[rule.first];
    float strength = degrees[p->term] * p->sign + p->offset;
    for (std::size_t k = 1; k < rule.count; ++k) {
        ++p;
        const float next = degrees[p->term] * p->sign + p->offset;
        strength = rule.any ? std::max(strength, next) : std::min(strength, next);
    }
    return strength * rule.weight;
}

float FuzzySystem::sugeno(const FlatOutput& output,
                          const Inputs& in,
                          const Degrees& degrees) const {
    float weights = 0.0F;
    float sum = 0.0F;
    for (std::size_t r = output.first_rule; r < output.first_rule + std::size_t{output.rules};
         ++r) {
        const float strength = fire(rules_[r], degrees);
        const float* line = &output.linear[rules_[r].then * (1 + inputs_.size())];
        weights += strength;
        if (output.constant) {
            sum += strength * *line;
            continue;
        }
        float value = *line;
        for (std::size_t k = 0; k < inputs_.size(); ++k) {
            value += in[k] * line[1 + k];
        }
        sum += strength * value;
    }
    return weights > 0.0F ? sum / std::max(weights, 1e-30F) : output.otherwise;
}

float FuzzySystem::mamdani(const FlatOutput& output, const Degrees& degrees) const {
    std::array<float, kMaxOutputTerms> cut{};
    for (std::size_t r = output.first_rule; r < output.first_rule + std::size_t{output.rules};
         ++r) {
        float& highest = cut[rules_[r].then];
        highest = std::max(highest, fire(rules_[r], degrees));
    }
    float area = 0.0F;
    float moment = 0.0F;
    for (std::size_t s = 0; s < output.samples; ++s) {
        float height = 0.0F;
        for (std::size_t k = output.first_term[s]; k < output.first_term[s + 1]; ++k) {
            const SampleTerm& term = output.sample_terms[k];
            height = std::max(height, std::min(cut[term.term], term.degree));
        }
        area += height;
        moment += height * output.position[s];
    }
    return area > 0.0F ? moment / std::max(area, 1e-30F) : output.otherwise;
}

void FuzzySystem::explain(std::span<const float> in, std::vector<float>& degrees_of_rules) const {
    Inputs within;
    Degrees degrees;
    fuzzify(in, within, degrees);
    degrees_of_rules.assign(rules_.size(), 0.0F);
    for (std::size_t r = 0; r < rules_.size(); ++r) {
        degrees_of_rules[rule_number_[r]] = fire(rules_[r], degrees);
    }
}

}  // namespace zoned::ai::fuzzy
