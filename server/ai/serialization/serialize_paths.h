// serialize_paths(), deserialize_paths(): the paths of all agents of a zone as bytes.
#pragma once

#include "server/ai/ai_update.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai {

/// Appends all path requests and their state, between two ticks: little endian, after a version and
/// counts. The maps themselves are baked anew. False: the state is not `whole` (SavedPaths).
bool serialize_paths(const PathService& paths, std::vector<std::uint8_t>& out);

/// Reads the output of serialize_paths() into `paths`. These must be new, for the same ground with
/// its doors as they were. Load `agents` and their `step` first.
///
/// Empty text: done, and agents go on bit for bit (but see pathfinding::SavedPaths). Otherwise the
/// text names the error, with the path. Errors are another version, missing bytes, extra bytes, and
/// numbers that are invalid for these maps and agents. After an error discard `paths`, and give the
/// agents new ones: they request their paths anew.
std::string deserialize_paths(std::span<const std::uint8_t> bytes,
                              const AgentStore& agents,
                              PathService& paths,
                              AiUpdate& step);

}  // namespace zoned::ai
