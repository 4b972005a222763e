// Reload: what a config that was read anew may change in a world that runs: minds, and nothing
// else.
#pragma once

#include "server/ops/settings.h"
#include "shared/core/result.h"

#include <memory>
#include <string>

namespace zoned::ops {

/// Minds of `fresh` for a world that was made of `running`: machines, behaviours, parameters,
/// difficulties, fuzzy systems, trees, domains, `ai`, and what types say of their minds. Fails,
/// naming the setting, where anything else differs, and where a type gets a mind that had none or
/// loses the one it had.
core::Result<std::shared_ptr<const ai::Settings>> new_minds(const Settings& running,
                                                            const Settings& fresh);

}  // namespace zoned::ops
