// Reload: what a config that was read anew may change in a world that runs: agents, and nothing
// else.
#pragma once

#include "shared/core/result.h"

#include <memory>
#include <string>

namespace zoned::ai {
struct AiSettings;
}

namespace zoned::config {

struct Settings;

/// Agents of `fresh` for a world that was made of `running`: brains, behaviours, parameters,
/// difficulties, fuzzy systems, trees, domains, `ai`, and what types say of their agents. Fails,
/// naming the setting, where anything else differs, and where a type gets an agent that had none or
/// loses the one it had.
core::Result<std::shared_ptr<const ai::AiSettings>> new_brains(const Settings& running,
                                                               const Settings& fresh);

}  // namespace zoned::config
