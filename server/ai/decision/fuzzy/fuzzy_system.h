// FuzzySystem: fuzzy rules compiled to tables.
#pragma once

#include "server/ai/decision/fuzzy/membership.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::fuzzy {

/// Conjunction is the minimum, disjunction the maximum. Several rules may set the same value or
/// term of an output. Under Sugeno each rule counts by itself, weighted by its degree (weighted
/// average). Under Mamdani the largest degree cuts the term off. The centroid is then summed up at
/// the middles of `samples` equal pieces of the output's range.
class FuzzySystem {
  public:
    /// `def` must have no defects except kGap, kNeverSaid and kOutside, which are harmless.
    explicit FuzzySystem(const FuzzyDef& def);

    [[nodiscard]] std::size_t inputs() const { return inputs_.size(); }

    [[nodiscard]] std::size_t outputs() const { return outputs_.size(); }

    /// `in`: any value for each input (NaN counts as the low end). `out`: a value for each output,
    /// always within the output's range. Allocates nothing.
    void evaluate(std::span<const float> in, std::span<float> out) const;

    /// The degrees to which the rules of the last definition fire for these inputs; used by
    /// "explain".
    void explain(std::span<const float> in, std::vector<float>& degrees) const;

  private:
    struct SystemInput {
        float low = 0.0F;
        float high = 1.0F;
        std::uint16_t first = 0;  ///< index of the first of its terms
        std::uint16_t count = 0;
    };

    struct FlatRule {
        std::uint16_t first = 0;  ///< index of the first of its propositions
        std::uint16_t count = 0;
        bool any = false;
        float weight = 1.0F;
        std::uint16_t then = 0;
    };

    /// A degree times `sign` plus `offset`: the degree itself, or 1 minus the degree.
    struct FlatProposition {
        std::uint16_t term = 0;
        float sign = 1.0F;
        float offset = 0.0F;
    };

    /// A term of an output at one sample.
    struct SampleTerm {
        std::uint16_t term = 0;
        float degree = 0.0F;
    };

    struct FlatOutput {
        Inference inference = Inference::kSugeno;
        float low = 0.0F;
        float high = 1.0F;
        float otherwise = 0.0F;
        std::uint16_t first_rule = 0;
        std::uint16_t rules = 0;
        std::uint16_t terms = 0;
        std::uint16_t samples = 0;
        std::vector<float> linear;              ///< (1 + inputs) x values: constant, then by input
        bool constant = true;                   ///< no value depends on an input
        std::vector<std::uint32_t> first_term;  ///< index of the first term by sample, plus one
                                                ///< past the end
        std::vector<SampleTerm> sample_terms;   ///< the terms that are above 0 at a sample
        std::vector<float> position;            ///< position of each sample
    };

    using Inputs = std::array<float, kMaxInputs>;
    using Degrees = std::array<float, kMaxTerms>;

    void add_output(const FuzzyDef& def, std::size_t index);
    void lay_out_samples(const FuzzyOutput& output, FlatOutput& to) const;
    [[nodiscard]] float fire(const FlatRule& rule, const Degrees& degrees) const;
    [[nodiscard]] float sugeno(const FlatOutput& output,
                               const Inputs& in,
                               const Degrees& degrees) const;
    [[nodiscard]] float mamdani(const FlatOutput& output, const Degrees& degrees) const;
    void fuzzify(std::span<const float> in, Inputs& within, Degrees& degrees) const;

    std::vector<SystemInput> inputs_;
    std::vector<FlatTerm> terms_;
    std::vector<FlatProposition> propositions_;
    std::vector<FlatRule> rules_;             ///< by output
    std::vector<std::uint16_t> rule_number_;  ///< number in the definition
    std::vector<FlatOutput> outputs_;
};

/// The most outputs of a system.
inline constexpr std::size_t kMaxOutputs = 8;

}  // namespace zoned::ai::fuzzy
