#include "server/ai/decision/fuzzy/fuzzy_def.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace zoned::ai::fuzzy {

namespace {

bool well_formed(const Term& term) {
    return std::isfinite(term.b) && std::isfinite(term.c) && term.a <= term.b && term.b <= term.c &&
           term.c <= term.d;
}

class FuzzyInspection {
  public:
    void inputs(const std::vector<FuzzyVariable>& inputs) {
        std::size_t terms = 0;
        for (std::size_t i = 0; i < inputs.size(); ++i) {
            const FuzzyVariable& variable = inputs[i];
            const auto at = static_cast<int>(i);
            range_and_terms(FuzzyPart::kInput, at, variable.low, variable.high, variable.terms);
            terms += variable.terms.size();
            if (i == kMaxInputs ||
                (terms > kMaxTerms && terms - variable.terms.size() <= kMaxTerms)) {
                add(FuzzyDefectKind::kTooMany, FuzzyPart::kInput, at);
            }
        }
    }

    void outputs(const FuzzyDef& def) {
        for (std::size_t o = 0; o < def.outputs.size(); ++o) {
            const auto at = static_cast<int>(o);
            const FuzzyOutput& output = def.outputs[o];
            const bool sugeno = output.inference == Inference::kSugeno;
            const std::size_t count = sugeno ? output.values.size() : output.terms.size();
            if (sugeno) {
                if (!(output.high > output.low)) {
                    add(FuzzyDefectKind::kBadRange, FuzzyPart::kOutput, at);
                }
                if (count == 0) {
                    add(FuzzyDefectKind::kNoTerms, FuzzyPart::kOutput, at);
                }
            } else {
                terms(FuzzyPart::kOutput, at, output.low, output.high, output.terms);
                if (output.samples < 10 || output.samples > 1000) {
                    add(FuzzyDefectKind::kBadSamples, FuzzyPart::kOutput, at);
                }
            }
            if (count > kMaxOutputTerms) {
                add(FuzzyDefectKind::kTooMany, FuzzyPart::kOutput, at);
            }
            if (!(output.otherwise >= output.low && output.otherwise <= output.high)) {
                add(FuzzyDefectKind::kBadOtherwise, FuzzyPart::kOutput, at);
            }
            for (std::size_t v = 0; v < count; ++v) {
                const bool said =
                    std::any_of(def.rules.begin(), def.rules.end(), [&](const Rule& rule) {
                        return rule.output == o && rule.then == v;
                    });
                if (!said) {
                    add(FuzzyDefectKind::kNeverSaid, FuzzyPart::kOutput, at, static_cast<int>(v));
                }
            }
        }
    }

    void rules(const FuzzyDef& def) {
        for (std::size_t r = 0; r < def.rules.size(); ++r) {
            const Rule& rule = def.rules[r];
            const auto at = static_cast<int>(r);
            if (rule.when.empty()) {
                add(FuzzyDefectKind::kNoProposition, FuzzyPart::kRule, at);
            }
            for (std::size_t p = 0; p < rule.when.size(); ++p) {
                if (!known(rule.when[p], def.inputs)) {
                    add(FuzzyDefectKind::kUnknownName, FuzzyPart::kRule, at, static_cast<int>(p));
                }
            }
            if (!(rule.weight > 0.0F && rule.weight <= 1.0F)) {
                add(FuzzyDefectKind::kBadWeight, FuzzyPart::kRule, at);
            }
            if (rule.output >= def.outputs.size() ||
                rule.then >= (def.outputs[rule.output].inference == Inference::kSugeno
                                  ? def.outputs[rule.output].values.size()
                                  : def.outputs[rule.output].terms.size())) {
                add(FuzzyDefectKind::kUnknownName, FuzzyPart::kRule, at);
            }
        }
    }

    std::vector<FuzzyDefect> defects;

  private:
    void add(FuzzyDefectKind kind,
             FuzzyPart part,
             int index,
             int element = -1,
             float from = 0.0F,
             float to = 0.0F) {
        defects.push_back({kind, part, index, element, from, to});
    }

    void range_and_terms(FuzzyPart part,
                         int at,
                         float low,
                         float high,
                         const std::vector<Term>& all) {
        if (terms(part, at, low, high, all)) {
            gaps(part, at, low, high, all);
        }
    }

    bool terms(FuzzyPart part, int at, float low, float high, const std::vector<Term>& all) {
        const std::size_t before = defects.size();
        if (!(high > low) || !std::isfinite(low) || !std::isfinite(high)) {
            add(FuzzyDefectKind::kBadRange, part, at);
        }
        if (all.empty()) {
            add(FuzzyDefectKind::kNoTerms, part, at);
        }
        for (std::size_t t = 0; t < all.size(); ++t) {
            if (!well_formed(all[t])) {
                add(FuzzyDefectKind::kBadTerm, part, at, static_cast<int>(t));
            } else if ((all[t].b > high && !(all[t].a < high)) ||
                       (all[t].c < low && !(all[t].d > low))) {
                add(FuzzyDefectKind::kOutside, part, at, static_cast<int>(t));
            }
        }
        return defects.size() == before;
    }

    /// Between two neighbouring corners either all values belong to a term or none does. So it is
    /// enough to test corners and the middles between them.
    void gaps(FuzzyPart part, int at, float low, float high, const std::vector<Term>& all) {
        std::vector<float> corners{low, high};
        for (const Term& term : all) {
            for (const float corner : {term.a, term.d}) {
                if (corner > low && corner < high) {
                    corners.push_back(corner);
                }
            }
        }
        std::sort(corners.begin(), corners.end());
        corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
        bool open = false;  // the last tested value belongs to a gap
        const auto look = [&](float value, float from, float to) {
            if (belongs(value, all)) {
                open = false;
            } else if (open) {
                defects.back().to = to;
            } else {
                add(FuzzyDefectKind::kGap, part, at, -1, from, to);
                open = true;
            }
        };
        for (std::size_t c = 0; c < corners.size(); ++c) {
            look(corners[c], corners[c], corners[c]);
            if (c + 1 < corners.size()) {
                look(0.5F * (corners[c] + corners[c + 1]), corners[c], corners[c + 1]);
            }
        }
    }

    static bool belongs(float value, const std::vector<Term>& all) {
        return std::any_of(all.begin(), all.end(), [value](const Term& term) {
            return (value > term.a || (value == term.a && term.a == term.b)) &&
                   (value < term.d || (value == term.d && term.c == term.d));
        });
    }
};

}  // namespace

std::vector<FuzzyDefect> defects_of(const FuzzyDef& def) {
    FuzzyInspection inspection;
    inspection.inputs(def.inputs);
    inspection.outputs(def);
    inspection.rules(def);
    return std::move(inspection.defects);
}

bool known(const Proposition& proposition, const std::vector<FuzzyVariable>& inputs) {
    return proposition.variable < inputs.size() &&
           proposition.term < inputs[proposition.variable].terms.size();
}

std::string text_of(const FuzzyDefect& defect) {
    switch (defect.kind) {
        case FuzzyDefectKind::kBadRange:
            return "high must be above low";
        case FuzzyDefectKind::kNoTerms:
            return "needs at least one term or value";
        case FuzzyDefectKind::kBadTerm:
            return "corners must ascend";
        case FuzzyDefectKind::kOutside:
            return "lies outside of the variable's range";
        case FuzzyDefectKind::kGap: {
            std::array<char, 120> text{};
            std::snprintf(text.data(),
                          text.size(),
                          defect.from == defect.to ? "the value %g belongs to no term"
                                                   : "values between %g and %g belong to no term",
                          static_cast<double>(defect.from),
                          static_cast<double>(defect.to));
            return text.data();
        }
        case FuzzyDefectKind::kNoProposition:
            return "needs at least one proposition";
        case FuzzyDefectKind::kUnknownName:
            return "speaks of something that does not exist";
        case FuzzyDefectKind::kBadWeight:
            return "a weight is above 0 and at most 1";
        case FuzzyDefectKind::kNeverSaid:
            return "no rule ever says this";
        case FuzzyDefectKind::kBadOtherwise:
            return "`otherwise` must lie within the range";
        case FuzzyDefectKind::kBadSamples:
            return "10 to 1000 samples";
        case FuzzyDefectKind::kTooMany:
            return "is one too many: at most " + std::to_string(kMaxInputs) + " inputs with " +
                   std::to_string(kMaxTerms) + " terms in all, and " +
                   std::to_string(kMaxOutputTerms) + " terms of an output";
    }
    return "is wrong";
}

}  // namespace zoned::ai::fuzzy
