#include "server/app/world/agent_reload.h"

#include "server/app/world/world_rules.h"
#include "server/config/expand/load_settings.h"
#include "server/config/expand/reload_diff.h"

#include <exception>
#include <utility>

namespace zoned::app {

namespace {

using Fresh = core::Result<mailbox::NewBrains>;

Fresh brains_of(const config::Settings& fresh, const config::Settings& running) {
    auto brains = config::new_brains(running, fresh);
    if (!brains.ok()) {
        return Fresh::failure(brains.error());
    }
    return mailbox::NewBrains{std::make_shared<const std::string>(fresh.text), *brains};
}

}  // namespace

core::Result<bool> restore_brains(const config::Settings& running, mailbox::InboxItem& item) {
    auto* brains = std::get_if<mailbox::NewBrains>(&item);
    if (brains == nullptr || brains->settings != nullptr) {
        return true;
    }
    config::Settings fresh;
    std::vector<config::ConfigError> errors;
    if (!config::parse_settings(*brains->config, {}, fresh, errors)) {
        return core::Result<bool>::failure(
            config::format_errors("the config that was read anew", errors));
    }
    Fresh read = brains_of(fresh, running);
    if (!read.ok()) {
        return core::Result<bool>::failure(read.error());
    }
    try {
        try_world_rules(fresh);
    } catch (const std::exception& error) {
        return core::Result<bool>::failure(error.what());
    }
    *brains = std::move(*read);
    return true;
}

}  // namespace zoned::app
