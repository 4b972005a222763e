// The paths of all agents of a zone, written down and read again. Reached by no program yet:
// snapshots of zones will use it.
#pragma once

#include "server/ai/ai_update.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai {

/// Appends who has asked for a path and what has become of it, between two ticks: little endian,
/// after a version and counts. The maps themselves are baked anew.
void serialize_paths(const PathService& paths, std::vector<std::uint8_t>& out);

/// Reads what serialize_paths() wrote into `paths` that were just made for the same ground, with
/// doors as they were, after `agents` and their `step` were read. Empty text: done, and agents go
/// on bit for bit (but see pathfinding::SavedPaths). Otherwise it says what is wrong, with the
/// path: another version, cut short, bytes left over, or numbers that mean nothing to these maps
/// and agents; then the paths are of no use, and agents may be given new ones: they ask anew.
std::string deserialize_paths(std::span<const std::uint8_t> bytes,
                              const AgentStore& agents,
                              PathService& paths,
                              AiUpdate& step);

}  // namespace zoned::ai
