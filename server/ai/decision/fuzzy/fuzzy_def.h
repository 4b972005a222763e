// FuzzyDef: fuzzy variables, rules and outputs as they are written down, and what is wrong with
// them.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace zoned::ai::fuzzy {

inline constexpr std::size_t kMaxInputs = 16;
inline constexpr std::size_t kMaxTerms = 128;       ///< of all inputs
inline constexpr std::size_t kMaxOutputTerms = 32;  ///< of one output

/// A trapezoid: 0 up to `a`, 1 from `b` to `c`, 0 from `d` on, straight lines between. a == b or
/// c == d makes an edge upright, which belongs to the term; b == c a triangle; an infinite a or d
/// a shoulder.
struct Term {
    std::string name;
    float a = -std::numeric_limits<float>::infinity();
    float b = 0.0F;
    float c = 0.0F;
    float d = std::numeric_limits<float>::infinity();
};

/// What an input may be. Values beyond the range count as its ends.
struct FuzzyVariable {
    std::string name;
    float low = 0.0F;
    float high = 1.0F;  ///< > low
    std::vector<Term> terms;
};

struct Proposition {
    std::uint16_t variable = 0;
    std::uint16_t term = 0;
    bool negated = false;  ///< 1 minus the degree
};

/// Takagi and Sugeno, "Fuzzy identification of systems and its applications to modeling and
/// control", IEEE Transactions on Systems, Man, and Cybernetics 15, 1985: a rule's output is a
/// linear function of the inputs. Mamdani and Assilian, "An experiment in linguistic synthesis with
/// a fuzzy logic controller", International Journal of Man-Machine Studies 7, 1975: it is a fuzzy
/// set, cut off at the rule's degree; the output is the centroid of their union.
enum class Inference : std::uint8_t {
    kSugeno,
    kMamdani
};

/// A linear function of the inputs, for kSugeno.
struct Linear {
    std::string name;
    float constant = 0.0F;
    std::vector<float> of_input;  ///< by input; missing ones are 0
};

struct FuzzyOutput {
    std::string name;
    Inference inference = Inference::kSugeno;
    float low = 0.0F;  ///< the output never leaves [low, high]
    float high = 1.0F;
    float otherwise = 0.0F;       ///< where no rule says anything; within the range
    std::vector<Linear> values;   ///< kSugeno
    std::vector<Term> terms;      ///< kMamdani
    std::uint16_t samples = 100;  ///< kMamdani: places at which the union is summed up, [10, 1000]
};

struct Rule {
    std::vector<Proposition> when;  ///< at least one
    bool any = false;               ///< the largest of the degrees counts, else the smallest
    std::uint16_t output = 0;
    std::uint16_t then = 0;  ///< one of the output's values or terms
    float weight = 1.0F;     ///< of the rule's degree, (0, 1]
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
    kBadTerm,  ///< a, b, c, d do not ascend, or b or c are no numbers
    kOutside,  ///< a term that is 0 in all of its variable's range
    kGap,      ///< values that belong to no term
    kNoProposition,
    kUnknownName,  ///< a variable, term, output or value that does not exist
    kBadWeight,
    kNeverSaid,     ///< an output, or one of its values, that no rule speaks of
    kBadOtherwise,  ///< beyond the range
    kBadSamples,
    kTooMany,
};

enum class FuzzyPart : std::uint8_t {
    kInput,
    kOutput,
    kRule
};

/// A mistake and where it lies.
struct FuzzyDefect {
    FuzzyDefectKind kind = FuzzyDefectKind::kGap;
    FuzzyPart part = FuzzyPart::kInput;
    int index = 0;      ///< of the input, output or rule
    int element = -1;   ///< its term, value or proposition
    float from = 0.0F;  ///< kGap: the values between
    float to = 0.0F;
};

/// Without any, FuzzySystem takes it.
std::vector<FuzzyDefect> defects_of(const FuzzyDef& def);

/// Defects of inputs and of propositions alone, for others that speak in fuzzy terms.
std::vector<FuzzyDefect> input_defects(const std::vector<FuzzyVariable>& inputs);

/// True where variable and term exist.
bool known(const Proposition& proposition, const std::vector<FuzzyVariable>& inputs);

/// What is wrong, for a person.
std::string text_of(const FuzzyDefect& defect);

}  // namespace zoned::ai::fuzzy
