// save_agents(), load_agents(): agents as bytes, for snapshots of a zone.
#pragma once

#include "server/ai/ai_update.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai {

/// Appends, after a version and counts:
/// - the difficulty (difficulty.h);
/// - all agents, ascending by entity;
/// - the saved state of their update;
/// - the stock;
/// - the pheromones of nests, whose maps are baked anew.
/// Numbers are little endian, field by field as agent_fields.h visits them. A zone that loads the
/// bytes goes on bit for bit.
void save_agents(const AgentStore& agents,
                 const AiUpdate& step,
                 const PointsOfInterest& points_of_interest,
                 std::vector<std::uint8_t>& out);

/// Reads the output of save_agents() into empty `agents` and `step`. Stock goes into
/// `points_of_interest`, which must have the places of the settings. The settings (compiled) are
/// put on the level of the saved agents.
///
/// Empty text: done. Otherwise nothing was changed, and the text names the error, with the agent
/// and the field. Errors are another version, missing bytes, extra bytes, and numbers that are
/// invalid for `settings`.
std::string load_agents(std::span<const std::uint8_t> bytes,
                        AiSettings& settings,
                        AgentStore& agents,
                        AiUpdate& step,
                        PointsOfInterest& points_of_interest);

}  // namespace zoned::ai
