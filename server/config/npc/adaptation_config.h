// Adaptation: the difficulties among which a world goes by itself, and what is wrong with them.
#pragma once

#include "server/config/npc/policies.h"
#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;

/// Fills in settings.ai.difficulty: the brains of all difficulties, each made of `written` (the
/// config before brains were made of behaviours) and checked as the world's own are. Reports
/// neighbouring difficulties that are the same for all types, and which difficulty a mistake of a
/// brain comes with. The config has no other mistakes.
void expand_adaptation(const proto::config::Config& written,
                       const Policies& policies,
                       Settings& settings,
                       Diagnostics& diagnostics);

}  // namespace zoned::config
