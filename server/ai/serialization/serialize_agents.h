// serialize_agents: agents as bytes, for snapshots of a zone.
// Reached by no program yet: snapshots of zones will use it.
#pragma once

#include "server/ai/ai_update.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai {

/// Appends on which difficulty they are (difficulty.h), all agents, ascending by entity, what their
/// step remembers, what is in stock, and the scents of nests, whose maps are baked anew: little
/// endian, field by field as agent_fields.h has them, after a version and counts. What reads them
/// goes on bit for bit.
void save_agents(const AgentStore& agents,
                 const AiUpdate& step,
                 const PointsOfInterest& points_of_interest,
                 std::vector<std::uint8_t>& out);

/// Reads what save_agents() wrote into empty `agents`, `step`, and the stock into
/// `points_of_interest`, which have those of the settings; these are put on the level on which the
/// agents were. Empty text: done. Otherwise nothing was changed, and the text says what is wrong:
/// another version, cut short, bytes left over, or numbers that mean nothing to `settings` (which
/// are compiled), with the agent and the field.
std::string load_agents(std::span<const std::uint8_t> bytes,
                        AiSettings& settings,
                        AgentStore& agents,
                        AiUpdate& step,
                        PointsOfInterest& points_of_interest);

}  // namespace zoned::ai
