// Explain: what an agent is in the middle of, and what it waits for, in words for a person.
#pragma once

#include "server/ai/agent/decision.h"

#include <string>
#include <vector>

namespace zoned::ai {

/// Names of what a brain's conditions read, by SenseIndex.
std::vector<std::string> sense_names(const Brain& brain);

/// "walk -> stand where player distance above 20": transition `number` of a brain's table.
std::string transition_text(const Brain& brain,
                            const CompiledBrain& compiled,
                            std::uint16_t from,  ///< innermost states, as a change has them
                            std::uint16_t to,
                            std::uint16_t number);

/// Several lines: its states from the outermost in and since when, what it senses, the rules of its
/// fuzzy systems that fire and how much, and each transition of its states with what its conditions
/// read now, and how long it has held. `brain` as written and `compiled` are of the agent;
/// `random` is what the next decision would draw. `dt` in s.
std::string explain(const Agent& agent,
                    const Brain& brain,
                    const CompiledBrain& compiled,
                    const Percept& percept,
                    const Vec2& here,
                    const PointsOfInterest& points_of_interest,
                    Tick now,
                    float dt);

}  // namespace zoned::ai
