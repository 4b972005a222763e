// Ladder: difficulties from the easiest to the hardest, and on which of them a zone stands, as its
// players do.
#pragma once

#include "server/ai/learn/adaptation.h"
#include "server/ai/machine.h"
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
struct Rung {
    std::string name;
    std::vector<Brain> brains{};
    std::vector<CompiledBrain> compiled{};
};

struct LadderSettings {
    /// The easiest first; none: difficulty stays as it is. The brains of rung `active` are those
    /// of the settings themselves, and its own are empty.
    std::vector<Rung> rungs{};
    std::vector<bool> varies{};       ///< by brain: some rung has it otherwise than another
    learning::Staircase staircase{};  ///< in rungs: level 1 is the second
    std::uint16_t start = 0;          ///< rung, within the staircase's cap
    std::uint16_t active = 0;         ///< rung
    Tick between = 0;                 ///< at least, from one change of rung to the next
};

/// Where a zone stands.
struct Ladder {
    std::uint16_t rung = 0;
    float level = 0.0F;           ///< in rungs
    std::uint32_t successes = 0;  ///< of players, since the rung changed
    std::uint32_t failures = 0;
    Tick changed_at = 0;
};

/// Calls `visit(number)` for each number of a ladder, in one order; `ladder` may be const.
template <class LadderOf, class Visit>
void visit_fields(LadderOf& ladder, Visit&& visit)
    requires std::same_as<std::remove_const_t<LadderOf>, Ladder>
{
    visit(ladder.rung);
    visit(ladder.level);
    visit(ladder.successes);
    visit(ladder.failures);
    visit(ladder.changed_at);
}

/// For people: what a change came of.
struct RungChange {
    std::uint16_t from = 0;
    std::uint16_t to = 0;
    float level = 0.0F;
    std::uint32_t successes = 0;
    std::uint32_t failures = 0;
};

/// Where a zone begins.
Ladder first_of(const LadderSettings& settings);

/// A player has succeeded at what the agents made difficult, or failed. Nothing where there are no
/// rungs.
void note_outcome(Ladder& ladder, const LadderSettings& settings, bool player_succeeded);

/// The rung to stand on now. Another one is taken once the level has come all the way to it, so
/// that two are a whole rung of outcomes apart, and not before `between` is over. As the level
/// stays within its cap, the share of successes over n outcomes is that wanted to within
/// (most - least) / (step n), unless the level meets the cap.
std::uint16_t rung_due(const Ladder& ladder, const LadderSettings& settings, Tick now);

/// Brain `index` as rung `rung` has it.
const CompiledBrain& brain_at_level(const AiSettings& settings,
                                    std::uint16_t rung,
                                    std::size_t index);

/// Gives the settings the brains of a rung. Nothing is copied or allocated.
void put_on_rung(AiSettings& settings, std::uint16_t rung);

/// The zone goes to another rung: the agents of brains that vary, which are all active, go on with
/// those of that rung (adopt.h). `dt` in s.
RungChange change_rung(AgentStore& agents,
                       AiSettings& settings,
                       Ladder& ladder,
                       std::uint16_t rung,
                       Tick now,
                       float dt);

/// An agent that lived by the brains of another rung goes on by those of the settings.
void adopt_from_rung(Agent& agent,
                     const AiSettings& settings,
                     std::uint16_t rung,
                     Tick now,
                     float dt);

/// For settings that have come in the place of `before` in a zone that runs: puts them on the rung
/// of the same name, or else where they begin, and the ladder with them.
void go_on_with(Ladder& ladder, const LadderSettings& before, AiSettings& settings, Tick now);

}  // namespace zoned::ai
