#include "server/app/runtime/live_settings.h"

#include "server/app/log/log.h"
#include "server/app/runtime/host_settings.h"
#include "server/app/world/world_rules.h"
#include "server/config/expand/load_settings.h"

#include <asio/post.hpp>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <exception>
#include <utility>

namespace zoned::app {

namespace {

using Prepared = core::Result<PreparedReload>;

constexpr std::size_t kMostListed = 20;

Prepared prepared(config::Settings& fresh, const config::Settings& running) {
    try {
        declare_fields(fresh);
    } catch (const std::exception& error) {
        return Prepared::failure(error.what());
    }
    auto plan = config::plan_reload(running, fresh);
    if (!plan.ok()) {
        return Prepared::failure(plan.error());
    }
    PreparedReload out;
    out.plan = std::move(*plan);
    if (out.plan.merged) {
        try {
            out.limits = host_limits_of(*out.plan.merged);
            if (out.plan.brains) {
                // Whether a script compiles, and code has all that it names, shows when rules are
                // made.
                try_world_rules(*out.plan.merged);
            }
        } catch (const std::exception& error) {
            return Prepared::failure(error.what());
        }
    }
    return out;
}

std::string list_of(const std::vector<config::SettingChange>& changes, bool live) {
    std::string out;
    std::size_t listed = 0;
    for (const config::SettingChange& change : changes) {
        if (change.live != live) {
            continue;
        }
        if (++listed > kMostListed) {
            return out + ", ...";
        }
        out += fmt::format("{}{} {} -> {}{}",
                           out.empty() ? "" : ", ",
                           change.path,
                           change.before,
                           change.after,
                           change.note.empty() ? "" : " (" + change.note + ")");
    }
    return out;
}

}  // namespace

session::HostLimits host_limits_of(const config::Settings& settings) {
    return host_settings(settings);
}

Prepared prepare_reload(const std::string& file,
                        const std::vector<std::string>& sets,
                        const config::Settings& running) {
    config::Settings fresh;
    std::vector<config::ConfigError> errors;
    if (!config::load_settings(file, sets, fresh, errors)) {
        return Prepared::failure(config::format_errors(file, errors));
    }
    return prepared(fresh, running);
}

Prepared prepare_change(const std::string& path,
                        const std::string& value,
                        const config::Settings& running) {
    if (!config::is_live_setting(path)) {
        std::string list;
        for (const std::string& live : config::live_settings()) {
            list += (list.empty() ? "" : ", ") + live;
        }
        return Prepared::failure("'" + path +
                                 "' takes a restart, or is no setting; these change live, and "
                                 "agents' settings: " +
                                 list);
    }
    config::Settings fresh;
    std::vector<config::ConfigError> errors;
    if (!config::parse_settings(running.text, {path + "=" + value}, fresh, errors)) {
        return Prepared::failure(config::format_errors("--set", errors));
    }
    Prepared out = prepared(fresh, running);
    if (out.ok()) {
        for (const config::SettingChange& change : out->plan.changes) {
            if (!change.live) {
                return Prepared::failure(change.path + ": " + change.note);
            }
        }
    }
    return out;
}

LiveSettings::LiveSettings(asio::io_context& io, const config::Settings& begun, LivePorts ports)
    : io_(io),
      current_(std::shared_ptr<const config::Settings>(), &begun),
      ports_(std::move(ports)) {
}

void LiveSettings::reload(const std::string& file,
                          const std::vector<std::string>& sets,
                          const WhenTaken& done) {
    read_aside([file, sets, running = current_] { return prepare_reload(file, sets, *running); },
               done);
}

void LiveSettings::change(const std::string& path,
                          const std::string& value,
                          const WhenTaken& done) {
    read_aside([path, value, running = current_] { return prepare_change(path, value, *running); },
               done);
}

void LiveSettings::finish() {
    if (reader_.joinable()) {
        reader_.join();
    }
}

void LiveSettings::read_aside(std::function<Prepared()> read, const WhenTaken& done) {
    if (reading_) {
        done(Taken::failure("the config is being read already; try again"));
        return;
    }
    reading_ = true;
    finish();
    reader_ = std::thread([this, read = std::move(read), done] {
        asio::post(io_, [this, result = std::make_shared<Prepared>(read()), done] {
            reading_ = false;
            done(take(*result));
        });
    });
}

LiveSettings::Taken LiveSettings::take(const Prepared& prepared) {
    if (!prepared.ok()) {
        return Taken::failure(prepared.error());
    }
    const config::ReloadPlan& plan = prepared->plan;
    if (plan.brains && !ports_.set_brains(mailbox::NewBrains{
                           std::make_shared<const std::string>(plan.merged->text), plan.brains})) {
        return Taken::failure("no room for new brains in the mailbox: try again");
    }
    if (plan.merged) {
        ports_.set_limits(prepared->limits);
        if (plan.merged->server.log.levels != current_->server.log.levels) {
            Log::set_levels(plan.merged->server.log);
        }
        current_ = plan.merged;
    }
    return plan.changes;
}

std::string text_of(const std::vector<config::SettingChange>& changes) {
    const auto live = static_cast<std::size_t>(
        std::count_if(changes.begin(), changes.end(), [](const auto& c) { return c.live; }));
    const std::size_t waiting = changes.size() - live;
    if (changes.empty()) {
        return "nothing differs";
    }
    std::string out;
    if (live > 0) {
        out = fmt::format(
            "{} setting{} changed: {}", live, live == 1 ? "" : "s", list_of(changes, true));
    }
    if (waiting > 0) {
        out += fmt::format("{}{} wait{} for a restart: {}",
                           out.empty() ? "nothing changed; " : "; ",
                           waiting,
                           waiting == 1 ? "s" : "",
                           list_of(changes, false));
    }
    return out;
}

}  // namespace zoned::app
