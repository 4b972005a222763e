// Live settings: what a config that is read anew changes in a running server, made ready to be
// taken as a whole.
#pragma once

#include "server/config/expand/reload_plan.h"
#include "server/session/session_settings.h"
#include "shared/core/result.h"

#include <string>
#include <vector>

namespace zoned::app {

/// A plan with everything read that it needs: taking it cannot fail half-way.
struct PreparedReload {
    config::ReloadPlan plan;
    session::HostLimits limits;  ///< where plan.merged is set
};

/// The limits of the session host in these settings; reads the key files. Throws std::system_error
/// or std::runtime_error that names the file.
session::HostLimits host_limits_of(const config::Settings& settings);

/// Reads `file` with `sets` as for a start, and compares with what runs. Fails with all mistakes.
core::Result<PreparedReload> prepare_reload(const std::string& file,
                                            const std::vector<std::string>& sets,
                                            const config::Settings& running);

/// Changes one setting of what runs. Fails with the mistake, or where the setting takes a restart.
core::Result<PreparedReload> prepare_change(const std::string& path,
                                            const std::string& value,
                                            const config::Settings& running);

/// "2 settings changed: a.b 1 -> 2, ...; 1 waits for a restart: c.d 3 -> 4".
[[nodiscard]] std::string text_of(const std::vector<config::SettingChange>& changes);

}  // namespace zoned::app
