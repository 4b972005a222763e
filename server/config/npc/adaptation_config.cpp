#include "server/config/npc/adaptation_config.h"

#include "server/config/npc/behaviours.h"
#include "server/config/npc/blends.h"
#include "server/config/npc/brain_config.h"
#include "server/config/npc/choices.h"
#include "server/config/npc/difficulty_names.h"
#include "server/config/settings.h"
#include "server/config/text/config_numbers.h"
#include "proto/config/config.pb.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace zoned::config {

namespace {

using proto::config::Config;

/// Differences between the parameters of two difficulties, by type.
std::set<std::string> differing_types(const std::vector<ParameterChoice>& a,
                                      const std::vector<ParameterChoice>& b) {
    ZONED_ASSERT(a.size() == b.size(), "difficulties have the same parameters");
    std::set<std::string> types;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (a[i].value != b[i].value) {
            types.insert(a[i].type);
        }
    }
    return types;
}

/// The brains of one difficulty.
ai::DifficultyLevel expand_level(const Config& written,
                                 const std::string& name,
                                 const Policies& policies,
                                 std::vector<ParameterChoice>& choices,
                                 Diagnostics& diagnostics) {
    const std::size_t before = diagnostics.size();
    Config config = written;
    config.mutable_ai()->clear_adaptation();
    config.mutable_ai()->set_difficulty(name);
    choices = build_behaviours(config, diagnostics);
    check_choices(config, diagnostics);
    check_blends(config, diagnostics);
    check_brains(config, diagnostics);
    ai::DifficultyLevel level;
    level.name = name;
    if (diagnostics.size() == before) {
        level.brains = expand_brains(config);
        give_policies(config, policies, level.brains, diagnostics);
    }
    return level;
}

bool same_names(const std::vector<ai::Brain>& a, const std::vector<ai::Brain>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
        return x.name == y.name && x.inner == y.inner;
    });
}

void expand_staircase(const Config& config, double tick_rate_hz, ai::DifficultyLevels& difficulty) {
    const proto::config::Adaptation& adaptation = config.ai().adaptation();
    const LevelRange range = level_range(adaptation);
    difficulty.staircase = {narrow(adaptation.success()),
                            narrow(adaptation.step()),
                            static_cast<float>(range.least),
                            static_cast<float>(range.most)};
    difficulty.start = static_cast<std::uint16_t>(range.start);
    difficulty.active = difficulty.start;
    difficulty.between =
        static_cast<Tick>(std::llround(adaptation.least_between_s() * tick_rate_hz));
}

}  // namespace

void expand_adaptation(const Config& written,
                       const Policies& policies,
                       Settings& settings,
                       Diagnostics& diagnostics) {
    ai::DifficultyLevels& difficulty = settings.ai.difficulty;
    difficulty = {};
    if (!written.ai().has_adaptation()) {
        return;
    }
    const proto::config::Adaptation& adaptation = written.ai().adaptation();
    expand_staircase(written, settings.tick_rate_hz, difficulty);
    std::set<std::string> varying;
    std::vector<ParameterChoice> before;
    for (int k = 0; k < adaptation.difficulty_size(); ++k) {
        const std::size_t mistakes = diagnostics.size();
        std::vector<ParameterChoice> choices;
        ai::DifficultyLevel level =
            expand_level(written, adaptation.difficulty(k), policies, choices, diagnostics);
        if (diagnostics.size() != mistakes) {
            diagnostics.add(join_path(kAdaptationPath, "difficulty", k),
                            "by '" + adaptation.difficulty(k) +
                                "' brains get mistakes that they do not have at the start");
            difficulty = {};
            return;
        }
        ZONED_ASSERT(same_names(level.brains, settings.ai.brains),
                     "difficulties have the same brains");
        const std::set<std::string> types =
            k == 0 ? std::set<std::string>() : differing_types(before, choices);
        if (k > 0 && types.empty()) {
            diagnostics.add(join_path(kAdaptationPath, "difficulty", k),
                            "is the same as '" + adaptation.difficulty(k - 1) + "' for all types");
        }
        varying.insert(types.begin(), types.end());
        before = std::move(choices);
        for (const ai::Brain& brain : level.brains) {
            if (std::isfinite(settings.ai.viewer_range_m)) {
                settings.ai.viewer_range_m =
                    std::max(settings.ai.viewer_range_m, brain.perception_m);
            }
        }
        if (k == difficulty.active) {
            level.brains.clear();
        }
        difficulty.levels.push_back(std::move(level));
    }
    difficulty.varies.assign(settings.ai.brains.size(), false);
    for (const world::EntityType& type : settings.types) {
        if (type.brain != 0 && varying.count(type.name) != 0) {
            difficulty.varies[type.brain - 1U] = true;
        }
    }
}

}  // namespace zoned::config
