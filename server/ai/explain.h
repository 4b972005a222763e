// explain(): tells a person what an agent is doing, and what it waits for.
#pragma once

#include "server/ai/agent/decision.h"

#include <string>

namespace zoned::ai {

/// Text such as "walk -> stand where player distance above 20", for transition `number` of a
/// brain's table; where code makes the transitions, "walk -> stand by code: far".
std::string transition_text(const Brain& brain,
                            const CompiledBrain& compiled,
                            std::uint16_t from,  ///< innermost states, as in a StateChange
                            std::uint16_t to,
                            std::uint16_t number);

/// Explains one agent in several lines:
/// - its states from the outermost in, and since when;
/// - its senses, and the fuzzy rules that fire with their degrees;
/// - each transition of its states, with the current values of its conditions and how long it has
///   held; where code makes the transitions, the senses that it reads and the transition that it
///   holds.
/// `brain` (as written) and `compiled` belong to the agent. `random` is the number that the next
/// decision would draw. `dt` in s.
std::string explain(const Agent& agent,
                    const Brain& brain,
                    const CompiledBrain& compiled,
                    const Percept& percept,
                    const Vec2& here,
                    const PointsOfInterest& points_of_interest,
                    Tick now,
                    float dt);

}  // namespace zoned::ai
