// Live settings: which settings of a config may change without a restart, checked as in a config.
#pragma once

#include "server/session/host/session_figures.h"
#include "shared/core/result.h"

#include <functional>
#include <string>
#include <vector>

namespace zoned::app {

/// Puts the new value where it belongs.
using LiveChange = std::function<void(session::HostLimits&)>;

/// Reads the config with one more --set, so that the same checks hold as for a start. Fails with
/// the mistake, or where the setting takes a restart.
core::Result<LiveChange> changed_limits(const std::string& config,
                                        const std::vector<std::string>& sets,
                                        const std::string& path,
                                        const std::string& value);

}  // namespace zoned::app
