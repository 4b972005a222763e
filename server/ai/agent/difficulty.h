// DifficultyState: the difficulty level of a zone, which adapts to its players. Levels go from the
// easiest to the hardest.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/ai/learning/adaptation.h"
#include "shared/core/ids.h"

#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace zoned::ai {

class AgentStore;
struct Agent;
struct AiSettings;

/// All brains at one difficulty level. Each level has the same number of brains, with the same
/// names.
struct DifficultyLevel {
    std::string name;
    std::vector<Brain> brains{};
    std::vector<CompiledBrain> compiled{};
};

struct DifficultyLevels {
    /// The easiest level first; none: difficulty stays as it is. The brains of level `active` are
    /// in the settings themselves, and its own list is empty.
    std::vector<DifficultyLevel> levels{};
    std::vector<bool> varies{};       ///< by brain: it differs between levels
    learning::Staircase staircase{};  ///< in levels: position 1 is the second
    std::uint16_t start = 0;          ///< level, within the staircase's cap
    std::uint16_t active = 0;         ///< level
    Tick between = 0;                 ///< the shortest time from one change of level to the next
};

/// The difficulty of a zone.
struct DifficultyState {
    std::uint16_t level = 0;
    float position = 0.0F;        ///< in levels
    std::uint32_t successes = 0;  ///< of players, since the level changed
    std::uint32_t failures = 0;
    Tick changed_at = 0;
};

/// Calls `visit(number)` for each number of a difficulty, always in the same order. `difficulty`
/// may be const.
template <class StateOf, class Visit>
void visit_fields(StateOf& difficulty, Visit&& visit)
    requires std::same_as<std::remove_const_t<StateOf>, DifficultyState>
{
    visit(difficulty.level);
    visit(difficulty.position);
    visit(difficulty.successes);
    visit(difficulty.failures);
    visit(difficulty.changed_at);
}

/// The cause of a change of level, for people.
struct LevelChange {
    std::uint16_t from = 0;
    std::uint16_t to = 0;
    float position = 0.0F;
    std::uint32_t successes = 0;
    std::uint32_t failures = 0;
};

/// The difficulty with which a zone begins.
DifficultyState first_of(const DifficultyLevels& settings);

/// Records that a player has succeeded or failed at a task that the agents made difficult. Does
/// nothing where there are no levels.
void note_outcome(DifficultyState& difficulty,
                  const DifficultyLevels& settings,
                  bool player_succeeded);

/// The level that the zone should be on now. It changes only once the position has fully reached
/// another level, and `between` has passed. So two changes are a whole level of outcomes apart. Let
/// the position stay within its cap: over n outcomes the share of successes is the desired one to
/// within (most - least) / (step n).
std::uint16_t level_due(const DifficultyState& difficulty,
                        const DifficultyLevels& settings,
                        Tick now);

/// Brain `index` at level `level`.
const CompiledBrain& brain_at_level(const AiSettings& settings,
                                    std::uint16_t level,
                                    std::size_t index);

/// Exchanges the brains of the settings for those of a level. Copies and allocates nothing.
void put_on_level(AiSettings& settings, std::uint16_t level);

/// Moves the zone to another level. The agents of brains that vary, all active, go on with the
/// brains of that level (hot_reload_migration.h). `dt` in s.
LevelChange change_level(AgentStore& agents,
                         AiSettings& settings,
                         DifficultyState& difficulty,
                         std::uint16_t level,
                         Tick now,
                         float dt);

/// Moves an agent from the brains of another level to those of the settings.
void migrate_from_level(Agent& agent,
                        const AiSettings& settings,
                        std::uint16_t level,
                        Tick now,
                        float dt);

/// Moves a running zone from the settings `before` to new settings. The new settings and the
/// difficulty go to the level of the same name, or else to the level at which the new settings
/// begin.
void go_on_with(DifficultyState& difficulty,
                const DifficultyLevels& before,
                AiSettings& settings,
                Tick now);

}  // namespace zoned::ai
