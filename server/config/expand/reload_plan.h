// reload_plan: what a config that was read anew changes in a running world, and what of it waits
// for a restart.
#pragma once

#include "server/config/settings.h"
#include "shared/core/result.h"

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::config {

/// One setting that differs.
struct SettingChange {
    std::string path;
    std::string before;  ///< as text, shortened
    std::string after;
    bool live = false;  ///< false: takes a restart
    std::string note;   ///< why it takes one, where that is not plain
};

struct ReloadPlan {
    std::vector<SettingChange> changes;
    /// The running settings with all live changes; null: there are none.
    std::shared_ptr<const Settings> merged;
    /// Agents' settings to put into the world; null: they stay.
    std::shared_ptr<const ai::AiSettings> brains;
};

/// Compares two good configs. All live changes make one whole, which is checked like a config: they
/// are to be taken together or not at all. Fails where they make no good config without those that
/// take a restart.
core::Result<ReloadPlan> plan_reload(const Settings& running, const Settings& fresh);

/// The settings of the server process that may change while it runs; agents' settings may too.
[[nodiscard]] std::vector<std::string> live_settings();

/// Whether a setting, or all below it, may change in a running world.
[[nodiscard]] bool is_live_setting(std::string_view path);

}  // namespace zoned::config
