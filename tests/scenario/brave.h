// Brave: a fuzzy system of nine rules that says how boldly to act, by Sugeno or by Mamdani.
#pragma once

#include "server/ai/decision/fuzzy/fuzzy_def.h"

#include <limits>

namespace zoned::scenario {

/// Distance of the foe, m [0, 40], and health [0, 1], three terms each; boldness [0, 1].
inline ai::fuzzy::FuzzyDef brave_def(ai::fuzzy::Inference inference) {
    using ai::fuzzy::FuzzyDef;
    const float infinity = std::numeric_limits<float>::infinity();
    FuzzyDef def;
    def.name = "brave";
    def.inputs = {
        {"distance",
         0,
         40,
         {{"near", -infinity, 5, 5, 15}, {"middle", 5, 15, 15, 30}, {"far", 15, 30, 30, infinity}}},
        {"health",
         0,
         1,
         {{"low", -infinity, 0.2F, 0.2F, 0.5F},
          {"fair", 0.2F, 0.5F, 0.5F, 0.8F},
          {"good", 0.5F, 0.8F, 0.8F, infinity}}}};
    ai::fuzzy::FuzzyOutput bold;
    bold.name = "boldness";
    bold.inference = inference;
    bold.low = 0;
    bold.high = 1;
    if (inference == ai::fuzzy::Inference::kSugeno) {
        bold.values = {{"timid", 0.1F, {}}, {"wary", 0.5F, {}}, {"bold", 0.9F, {}}};
    } else {
        bold.terms = {{"timid", 0, 0, 0.25F, 0.5F},
                      {"wary", 0.25F, 0.5F, 0.5F, 0.75F},
                      {"bold", 0.5F, 0.75F, 1, 1}};
    }
    def.outputs = {bold};
    // Rows: near, middle, far; columns: low, fair, good.
    constexpr std::uint16_t kThen[3][3] = {{0, 1, 2}, {0, 1, 2}, {1, 1, 2}};
    for (std::uint16_t d = 0; d < 3; ++d) {
        for (std::uint16_t h = 0; h < 3; ++h) {
            def.rules.push_back({{{0, d, false}, {1, h, false}}, false, 0, kThen[d][h], 1.0F});
        }
    }
    return def;
}

}  // namespace zoned::scenario
