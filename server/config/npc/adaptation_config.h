// adaptation_config: reads and checks the difficulties that a world changes by itself.
#pragma once

#include "server/config/npc/policies.h"
#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;

/// Fills in settings.ai.difficulty: the brains of all difficulties. Each is made from `written`,
/// the config before brains were made from behaviours, and checked like the world's own brains.
/// Reports neighbouring difficulties that are the same for all types. A mistake in a brain is
/// reported with its difficulty. The config has no other mistakes.
void expand_adaptation(const proto::config::Config& written,
                       const Policies& policies,
                       Settings& settings,
                       Diagnostics& diagnostics);

}  // namespace zoned::config
