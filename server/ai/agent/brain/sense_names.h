// Sense names: the senses of a brain's agents by name, for people and for code.
#pragma once

#include "server/ai/agent/brain/brain.h"

#include <string>
#include <vector>

namespace zoned::ai {

/// Names for people, by SenseIndex.
std::vector<std::string> sense_names(const Brain& brain);

/// Names as configs write them, by SenseIndex: sensors such as PLAYER_DISTANCE, then variables,
/// "SYSTEM.OUTPUT" and "PLACE.distance" or "PLACE.GOOD".
std::vector<std::string> config_sense_names(const Brain& brain);

}  // namespace zoned::ai
