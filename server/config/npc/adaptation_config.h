// Adaptation: the difficulties among which a world goes by itself, and what is wrong with them.
#pragma once

#include "server/config/npc/policies.h"
#include "server/config/settings.h"
#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

/// The difficulty that the world begins with: `ai.difficulty`, or where `ai.adaptation` starts;
/// empty: parameters are as types say.
std::string first_difficulty(const proto::config::Config& config);

/// `ai.adaptation` by itself: names that are none, given twice or not in the list, a start outside
/// of least and most, a difficulty chosen besides.
void check_adaptation(const proto::config::Config& config, Diagnostics& diagnostics);

/// Fills in settings.ai.difficulty: the brains of all difficulties, each made of `written` (the
/// config before brains were made of behaviours) and checked as the world's own are. Reports
/// neighbouring difficulties that are the same for all types, and which difficulty a mistake of a
/// brain comes with. The config has no other mistakes.
void expand_adaptation(const proto::config::Config& written,
                       const Policies& policies,
                       Settings& settings,
                       Diagnostics& diagnostics);

}  // namespace zoned::config
