#include "server/app/runtime/live_settings.h"

#include "server/config/expand/load_settings.h"

#include <algorithm>
#include <array>

namespace zoned::app {

namespace {

struct LiveSetting {
    const char* path;
    void (*take)(const config::ServerSettings& from, session::HostLimits& to);
};

constexpr std::array<LiveSetting, 4> kLive{{
    {"network.max_clients",
     [](const config::ServerSettings& from, session::HostLimits& to) {
         to.max_sessions = from.network.max_clients;
     }},
    {"network.silence_timeout_s",
     [](const config::ServerSettings& from, session::HostLimits& to) {
         to.silence_timeout_s = from.network.silence_timeout_s;
     }},
    {"session.grace_s",
     [](const config::ServerSettings& from, session::HostLimits& to) {
         to.grace_s = from.session.grace_s;
     }},
    {"session.login_timeout_s",
     [](const config::ServerSettings& from, session::HostLimits& to) {
         to.login_timeout_s = from.session.login_timeout_s;
     }},
}};

std::string live_paths() {
    std::string out;
    for (const LiveSetting& setting : kLive) {
        out += (out.empty() ? "" : ", ") + std::string(setting.path);
    }
    return out;
}

}  // namespace

core::Result<LiveChange> changed_limits(const std::string& config,
                                        const std::vector<std::string>& sets,
                                        const std::string& path,
                                        const std::string& value) {
    using Out = core::Result<LiveChange>;
    const auto setting = std::find_if(
        kLive.begin(), kLive.end(), [&](const LiveSetting& live) { return path == live.path; });
    if (setting == kLive.end()) {
        return Out::failure(
            "'" + path + "' takes a restart, or is no setting; these change live: " + live_paths());
    }
    std::vector<std::string> more = sets;
    more.push_back(path + "=" + value);
    config::Settings fresh;
    std::vector<config::ConfigError> errors;
    if (!config::load_settings(config, more, fresh, errors)) {
        return Out::failure(config::format_errors(config, errors));
    }
    return LiveChange([take = setting->take, server = fresh.server](session::HostLimits& limits) {
        take(server, limits);
    });
}

}  // namespace zoned::app
