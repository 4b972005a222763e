#include "server/ai/fuzzy/fuzzy_def.h"

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
    void inputs(const std::vector<Variable>& inputs) {
        std::size_t terms = 0;
        for (std::size_t i = 0; i < inputs.size(); ++i) {
            const Variable& variable = inputs[i];
            const auto at = static_cast<int>(i);
            range_and_terms(Part::kInput, at, variable.low, variable.high, variable.terms);
            terms += variable.terms.size();
            if (i == kMaxInputs ||
                (terms > kMaxTerms && terms - variable.terms.size() <= kMaxTerms)) {
                add(DefectKind::kTooMany, Part::kInput, at);
            }
        }
    }

    void outputs(const FuzzyDef& def) {
        for (std::size_t o = 0; o < def.outputs.size(); ++o) {
            const auto at = static_cast<int>(o);
            const Output& output = def.outputs[o];
            const bool sugeno = output.inference == Inference::kSugeno;
            const std::size_t count = sugeno ? output.values.size() : output.terms.size();
            if (sugeno) {
                if (!(output.high > output.low)) {
                    add(DefectKind::kBadRange, Part::kOutput, at);
                }
                if (count == 0) {
                    add(DefectKind::kNoTerms, Part::kOutput, at);
                }
            } else {
                terms(Part::kOutput, at, output.low, output.high, output.terms);
                if (output.samples < 10 || output.samples > 1000) {
                    add(DefectKind::kBadSamples, Part::kOutput, at);
                }
            }
            if (count > kMaxOutputTerms) {
                add(DefectKind::kTooMany, Part::kOutput, at);
            }
            if (!(output.otherwise >= output.low && output.otherwise <= output.high)) {
                add(DefectKind::kBadOtherwise, Part::kOutput, at);
            }
            for (std::size_t v = 0; v < count; ++v) {
                const bool said =
                    std::any_of(def.rules.begin(), def.rules.end(), [&](const Rule& rule) {
                        return rule.output == o && rule.then == v;
                    });
                if (!said) {
                    add(DefectKind::kNeverSaid, Part::kOutput, at, static_cast<int>(v));
                }
            }
        }
    }

    void rules(const FuzzyDef& def) {
        for (std::size_t r = 0; r < def.rules.size(); ++r) {
            const Rule& rule = def.rules[r];
            const auto at = static_cast<int>(r);
            if (rule.when.empty()) {
                add(DefectKind::kNoProposition, Part::kRule, at);
            }
            for (std::size_t p = 0; p < rule.when.size(); ++p) {
                if (!known(rule.when[p], def.inputs)) {
                    add(DefectKind::kUnknownName, Part::kRule, at, static_cast<int>(p));
                }
            }
            if (!(rule.weight > 0.0F && rule.weight <= 1.0F)) {
                add(DefectKind::kBadWeight, Part::kRule, at);
            }
            if (rule.output >= def.outputs.size() ||
                rule.then >= (def.outputs[rule.output].inference == Inference::kSugeno
                                  ? def.outputs[rule.output].values.size()
                                  : def.outputs[rule.output].terms.size())) {
                add(DefectKind::kUnknownName, Part::kRule, at);
            }
        }
    }

    std::vector<Defect> defects;

  private:
    void add(DefectKind kind,
             Part part,
             int index,
             int element = -1,
             float from = 0.0F,
             float to = 0.0F) {
        defects.push_back({kind, part, index, element, from, to});
    }

    void range_and_terms(Part part, int at, float low, float high, const std::vector<Term>& all) {
        if (terms(part, at, low, high, all)) {
            gaps(part, at, low, high, all);
        }
    }

    bool terms(Part part, int at, float low, float high, const std::vector<Term>& all) {
        const std::size_t before = defects.size();
        if (!(high > low) || !std::isfinite(low) || !std::isfinite(high)) {
            add(DefectKind::kBadRange, part, at);
        }
        if (all.empty()) {
            add(DefectKind::kNoTerms, part, at);
        }
        for (std::size_t t = 0; t < all.size(); ++t) {
            if (!well_formed(all[t])) {
                add(DefectKind::kBadTerm, part, at, static_cast<int>(t));
            } else if ((all[t].b > high && !(all[t].a < high)) ||
                       (all[t].c < low && !(all[t].d > low))) {
                add(DefectKind::kOutside, part, at, static_cast<int>(t));
            }
        }
        return defects.size() == before;
    }

    /// Between two neighbouring corners either all values belong to a term or none does, so that
    /// corners and the middles between them tell all.
    void gaps(Part part, int at, float low, float high, const std::vector<Term>& all) {
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
        bool open = false;  // the last value looked at belongs to a gap
        const auto look = [&](float value, float from, float to) {
            if (belongs(value, all)) {
                open = false;
            } else if (open) {
                defects.back().to = to;
            } else {
                add(DefectKind::kGap, part, at, -1, from, to);
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

std::vector<Defect> defects_of(const FuzzyDef& def) {
    FuzzyInspection inspection;
    inspection.inputs(def.inputs);
    inspection.outputs(def);
    inspection.rules(def);
    return std::move(inspection.defects);
}

std::vector<Defect> input_defects(const std::vector<Variable>& inputs) {
    FuzzyInspection inspection;
    inspection.inputs(inputs);
    return std::move(inspection.defects);
}

bool known(const Proposition& proposition, const std::vector<Variable>& inputs) {
    return proposition.variable < inputs.size() &&
           proposition.term < inputs[proposition.variable].terms.size();
}

std::string text_of(const Defect& defect) {
    switch (defect.kind) {
        case DefectKind::kBadRange:
            return "high must be above low";
        case DefectKind::kNoTerms:
            return "needs at least one term or value";
        case DefectKind::kBadTerm:
            return "corners must ascend";
        case DefectKind::kOutside:
            return "lies outside of the variable's range";
        case DefectKind::kGap: {
            std::array<char, 120> text{};
            std::snprintf(text.data(),
                          text.size(),
                          defect.from == defect.to ? "the value %g belongs to no term"
                                                   : "values between %g and %g belong to no term",
                          static_cast<double>(defect.from),
                          static_cast<double>(defect.to));
            return text.data();
        }
        case DefectKind::kNoProposition:
            return "needs at least one proposition";
        case DefectKind::kUnknownName:
            return "speaks of something that does not exist";
        case DefectKind::kBadWeight:
            return "a weight is above 0 and at most 1";
        case DefectKind::kNeverSaid:
            return "no rule ever says this";
        case DefectKind::kBadOtherwise:
            return "`otherwise` must lie within the range";
        case DefectKind::kBadSamples:
            return "10 to 1000 samples";
        case DefectKind::kTooMany:
            return "is one too many: at most " + std::to_string(kMaxInputs) + " inputs with " +
                   std::to_string(kMaxTerms) + " terms in all, and " +
                   std::to_string(kMaxOutputTerms) + " terms of an output";
    }
    return "is wrong";
}

}  // namespace zoned::ai::fuzzy
