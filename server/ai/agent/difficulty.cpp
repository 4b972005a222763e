#include "server/ai/agent/difficulty.h"

#include "server/ai/agent/hot_reload_migration.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai {

namespace {

/// Exchanges the brains of the settings and those stored at a level.
void exchange_brains(AiSettings& settings, std::uint16_t level) {
    DifficultyLevel& kept = settings.difficulty.levels[level];
    std::swap(settings.brains, kept.brains);
    std::swap(settings.compiled, kept.compiled);
}

}  // namespace

DifficultyState first_of(const DifficultyLevels& settings) {
    DifficultyState difficulty;
    difficulty.level = settings.start;
    difficulty.position = static_cast<float>(settings.start);
    return difficulty;
}

void note_outcome(DifficultyState& difficulty,
                  const DifficultyLevels& settings,
                  bool player_succeeded) {
    if (settings.levels.empty()) {
        return;
    }
    difficulty.position =
        learning::stepped(settings.staircase, difficulty.position, player_succeeded);
    ++(player_succeeded ? difficulty.successes : difficulty.failures);
}

std::uint16_t level_due(const DifficultyState& difficulty,
                        const DifficultyLevels& settings,
                        Tick now) {
    if (settings.levels.empty() || now - difficulty.changed_at < settings.between) {
        return difficulty.level;
    }
    const auto here = static_cast<float>(difficulty.level);
    if (difficulty.position >= here + 1.0F) {
        return static_cast<std::uint16_t>(std::floor(difficulty.position));
    }
    return difficulty.position <= here - 1.0F
               ? static_cast<std::uint16_t>(std::ceil(difficulty.position))
               : difficulty.level;
}

const CompiledBrain& brain_at_level(const AiSettings& settings,
                                    std::uint16_t level,
                                    std::size_t index) {
    const bool here = settings.difficulty.levels.empty() || level == settings.difficulty.active;
    return here ? settings.compiled[index] : settings.difficulty.levels[level].compiled[index];
}

void put_on_level(AiSettings& settings, std::uint16_t level) {
    if (settings.difficulty.levels.empty() || level == settings.difficulty.active) {
        return;
    }
    exchange_brains(settings, settings.difficulty.active);
    exchange_brains(settings, level);
    settings.difficulty.active = level;
}

void migrate_from_level(Agent& agent,
                        const AiSettings& settings,
                        std::uint16_t level,
                        Tick now,
                        float dt) {
    if (level == settings.difficulty.active || settings.difficulty.levels.empty() ||
        !settings.difficulty.varies[agent.brain]) {
        return;
    }
    migrate(agent,
            brain_at_level(settings, level, agent.brain),
            settings.compiled[agent.brain],
            agent.brain,
            now,
            dt);
}

LevelChange change_level(AgentStore& agents,
                         AiSettings& settings,
                         DifficultyState& difficulty,
                         std::uint16_t level,
                         Tick now,
                         float dt) {
    const LevelChange change{
        difficulty.level, level, difficulty.position, difficulty.successes, difficulty.failures};
    put_on_level(settings, level);
    for (std::size_t n = 0; n < agents.size(); ++n) {
        Agent& agent = agents.at(agents.nth(n));
        ZONED_ASSERT(agent.tier != Tier::kSuspended || !settings.difficulty.varies[agent.brain],
                     "an agent that is to live by another brain was resumed");
        migrate_from_level(agent, settings, change.from, now, dt);
    }
    agents.forget_flapping();  // the numbers of transitions may differ
    difficulty.level = level;
    difficulty.successes = 0;
    difficulty.failures = 0;
    difficulty.changed_at = now;
    return change;
}

void go_on_with(DifficultyState& difficulty,
                const DifficultyLevels& before,
                AiSettings& settings,
                Tick now) {
    const DifficultyLevels& after = settings.difficulty;
    const auto same = [&](const DifficultyLevel& level) {
        return !before.levels.empty() && level.name == before.levels[difficulty.level].name;
    };
    const auto at = std::find_if(after.levels.begin(), after.levels.end(), same);
    const auto level = static_cast<std::uint16_t>(at - after.levels.begin());
    const learning::Staircase& cap = after.staircase;
    const auto wanted = static_cast<float>(level);
    if (at == after.levels.end() || wanted < cap.least || wanted > cap.most) {
        difficulty = first_of(after);
        difficulty.changed_at = now;
        return;
    }
    const float off = difficulty.position - static_cast<float>(difficulty.level);
    difficulty.position = std::clamp(wanted + off, cap.least, cap.most);
    difficulty.level = level;
    put_on_level(settings, level);
}

}  // namespace zoned::ai
