// reload_diff: checks that a reloaded config changes only the agents of a running world.
#pragma once

#include "shared/core/result.h"

#include <memory>
#include <string>

namespace zoned::ai {
struct AiSettings;
}

namespace zoned::config {

struct Settings;

/// Agents of `fresh` for a world that was made from `running`: brains, behaviours, parameters,
/// difficulties, fuzzy systems, trees, domains, `ai`, and the types' settings of agents. Fails,
/// naming the setting, where anything else differs. Fails too where a type gains or loses its
/// agent.
core::Result<std::shared_ptr<const ai::AiSettings>> new_brains(const Settings& running,
                                                               const Settings& fresh);

}  // namespace zoned::config
