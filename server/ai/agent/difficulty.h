// DifficultyState: difficulties from the easiest to the hardest, and on which of them a zone
// stands, as its players do.
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

/// All brains as one difficulty has them: as many, of the same names, as every other's.
struct DifficultyLevel {
    std::string name;
    std::vector<Brain> brains{};
    std::vector<CompiledBrain> compiled{};
};

struct DifficultyLevels {
    /// The easiest first; none: difficulty stays as it is. The brains of level `active` are those
    /// of the settings themselves, and its own are empty.
    std::vector<DifficultyLevel> levels{};
    std::vector<bool> varies{};       ///< by brain: some level has it otherwise than another
    learning::Staircase staircase{};  ///< in levels: position 1 is the second
    std::uint16_t start = 0;          ///< level, within the staircase's cap
    std::uint16_t active = 0;         ///< level
    Tick between = 0;                 ///< at least, from one change of level to the next
};

/// Where a zone stands.
struct DifficultyState {
    std::uint16_t level = 0;
    float position = 0.0F;        ///< in levels
    std::uint32_t successes = 0;  ///< of players, since the level changed
    std::uint32_t failures = 0;
    Tick changed_at = 0;
};

/// Calls `visit(number)` for each number of a difficulty, in one order; `difficulty` may be const.
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

/// For people: what a change came of.
struct LevelChange {
    std::uint16_t from = 0;
    std::uint16_t to = 0;
    float position = 0.0F;
    std::uint32_t successes = 0;
    std::uint32_t failures = 0;
};

/// Where a zone begins.
DifficultyState first_of(const DifficultyLevels& settings);

/// A player has succeeded at what the agents made difficult, or failed. Nothing where there are no
/// levels.
void note_outcome(DifficultyState& difficulty,
                  const DifficultyLevels& settings,
                  bool player_succeeded);

/// The level to stand on now. Another one is taken once the position has come all the way to it, so
/// that two are a whole level of outcomes apart, and not before `between` is over. As the position
/// stays within its cap, the share of successes over n outcomes is that wanted to within
/// (most - least) / (step n), unless the position meets the cap.
std::uint16_t level_due(const DifficultyState& difficulty,
                        const DifficultyLevels& settings,
                        Tick now);

/// Brain `index` as level `level` has it.
const CompiledBrain& brain_at_level(const AiSettings& settings,
                                    std::uint16_t level,
                                    std::size_t index);

/// Gives the settings the brains of a level. Nothing is copied or allocated.
void put_on_level(AiSettings& settings, std::uint16_t level);

/// The zone goes to another level: the agents of brains that vary, which are all active, go on with
/// those of that level (migrate.h). `dt` in s.
LevelChange change_level(AgentStore& agents,
                         AiSettings& settings,
                         DifficultyState& difficulty,
                         std::uint16_t level,
                         Tick now,
                         float dt);

/// An agent that lived by the brains of another level goes on by those of the settings.
void migrate_from_level(Agent& agent,
                        const AiSettings& settings,
                        std::uint16_t level,
                        Tick now,
                        float dt);

/// For settings that have come in the place of `before` in a zone that runs: puts them on the level
/// of the same name, or else where they begin, and the difficulty with them.
void go_on_with(DifficultyState& difficulty,
                const DifficultyLevels& before,
                AiSettings& settings,
                Tick now);

}  // namespace zoned::ai
