// FuzzyDef: the definition of fuzzy variables, rules and outputs, and the check for its defects.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace zoned::ai::fuzzy {

inline constexpr std::size_t kMaxInputs = 16;
inline constexpr std::size_t kMaxTerms = 128;       ///< most terms of all inputs together
inline constexpr std::size_t kMaxOutputTerms = 32;  ///< most terms of one output

/// A trapezoid: 0 up to `a`, 1 from `b` to `c`, 0 from `d` on, with straight lines between. a == b
/// or c == d makes an edge upright, and the edge belongs to the term. b == c makes a triangle. An
/// infinite a or d makes a shoulder.
struct Term {
    std::string name;
    float a = -std::numeric_limits<float>::infinity();
    float b = 0.0F;
    float c = 0.0F;
    float d = std::numeric_limits<float>::infinity();
};

/// FuzzyVariable: an input with its range and terms. Values beyond the range count as its ends.
struct FuzzyVariable {
    std::string name;
    float low = 0.0F;
    float high = 1.0F;  ///< > low
    std::vector<Term> terms;
};

struct Proposition {
    std::uint16_t variable = 0;
    std::uint16_t term = 0;
    bool negated = false;  ///< counts 1 minus the degree
};

/// The two methods of inference.
/// Sugeno: a rule's output is a linear function of the inputs. Source: Takagi and Sugeno, "Fuzzy
/// identification of systems and its applications to modeling and control", IEEE Transactions on
/// Systems, Man, and Cybernetics 15, 1985.
/// Mamdani: a rule's output is a fuzzy set, cut off at the rule's degree; the output is the
/// centroid of their union. Source: Mamdani and Assilian, "An experiment in linguistic synthesis
/// with a fuzzy logic controller", International Journal of Man-Machine Studies 7, 1975.
enum class Inference : std::uint8_t {
    kSugeno,
    kMamdani
};

/// A linear function of the inputs, for kSugeno.
struct Linear {
    std::string name;
    float constant = 0.0F;
    std::vector<float> of_input;  ///< factors by input; missing ones are 0
};

struct FuzzyOutput {
    std::string name;
    Inference inference = Inference::kSugeno;
    float low = 0.0F;  ///< the output never leaves [low, high]
    float high = 1.0F;
    float otherwise = 0.0F;       ///< the output where no rule fires; within the range
    std::vector<Linear> values;   ///< kSugeno
    std::vector<Term> terms;      ///< kMamdani
    std::uint16_t samples = 100;  ///< kMamdani: number of places at which the union is summed up,
                                  ///< [10, 1000]
};

struct Rule {
    std::vector<Proposition> when;  ///< at least one
    bool any = false;               ///< the largest of the degrees counts, else the smallest
    std::uint16_t output = 0;
    std::uint16_t then = 0;  ///< index of one of the output's values or terms
    float weight = 1.0F;     ///< factor of the rule's degree, (0, 1]
};

struct FuzzyDef {
    std::string name;
    std::vector<FuzzyVariable> inputs;
    std::vector<FuzzyOutput> outputs;
    std::vector<Rule> rules;
};

enum class FuzzyDefectKind : std::uint8_t {
    kBadRange,  ///< high is not above low
    kNoTerms,
    kBadTerm,  ///< a, b, c, d do not ascend, or b or c is not a number
    kOutside,  ///< a term that is 0 in all of its variable's range
    kGap,      ///< values that belong to no term
    kNoProposition,
    kUnknownName,  ///< a variable, term, output or value that does not exist
    kBadWeight,
    kNeverSaid,     ///< an output, or one of its values, that no rule uses
    kBadOtherwise,  ///< beyond the range
    kBadSamples,
    kTooMany,
};

enum class FuzzyPart : std::uint8_t {
    kInput,
    kOutput,
    kRule
};

/// FuzzyDefect: a mistake and its position.
struct FuzzyDefect {
    FuzzyDefectKind kind = FuzzyDefectKind::kGap;
    FuzzyPart part = FuzzyPart::kInput;
    int index = 0;      ///< index of the input, output or rule
    int element = -1;   ///< index of its term, value or proposition
    float from = 0.0F;  ///< kGap: the gap's ends
    float to = 0.0F;
};

/// All defects of `def`. FuzzySystem accepts a definition without any.
std::vector<FuzzyDefect> defects_of(const FuzzyDef& def);

/// True where the proposition's variable and term exist.
bool known(const Proposition& proposition, const std::vector<FuzzyVariable>& inputs);

/// The defect as a sentence for people.
std::string text_of(const FuzzyDefect& defect);

}  // namespace zoned::ai::fuzzy
