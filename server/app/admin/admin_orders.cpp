// The requests that change something, each logged.
#include "server/admin/json_body.h"
#include "server/app/admin/admin_api.h"
#include "server/app/admin/admin_figures.h"
#include "server/app/admin/admin_files.h"
#include "server/session/login/display_names.h"
#include "proto/admin.pb.h"
#include "shared/core/utf8.h"

#include <asio/post.hpp>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>

namespace zoned::app {

namespace {

using admin::json_response;
using admin::problem;

constexpr std::size_t kMaxReasonBytes = 256;
constexpr std::size_t kMaxAccountBytes = 64;
constexpr std::size_t kMaxNoticeBytes = 1024;
constexpr double kMostHours = 24.0 * 366.0 * 100.0;
constexpr double kMostGrace_s = 86400.0;

admin::AdminResponse done_with(const std::string& text, std::size_t count) {
    proto::admin::Done out;
    out.set_text(text);
    out.set_count(static_cast<std::uint32_t>(count));
    return json_response(out);
}

/// False, and replied, when the body is not such a message.
template <class Message>
bool read_body(const admin::AdminCall& call, const admin::AdminReply& reply, Message& out) {
    const auto read = admin::from_json(call.request.body, out);
    if (!read.ok()) {
        reply(problem(400, read.error()));
    }
    return read.ok();
}

/// False, and replied, when a text is too short, too long or not clean.
bool good_text(const std::string& text,
               const char* name,
               std::size_t least,
               std::size_t most,
               const admin::AdminReply& reply) {
    if (text.size() >= least && text.size() <= most && core::is_clean_utf8(text)) {
        return true;
    }
    reply(problem(400,
                  std::string(name) + " must be " + std::to_string(least) + " to " +
                      std::to_string(most) + " bytes of UTF-8 without control characters"));
    return false;
}

std::string count_of_sessions(std::size_t count) {
    return std::to_string(count) + (count == 1 ? " session" : " sessions");
}

}  // namespace

std::vector<admin::AdminRoute> AdminApi::orders() {
    std::vector<admin::AdminRoute> out;
    const auto post = [&](const char* path, auto handle) {
        out.push_back({"POST", path, false, handle});
    };
    post("/api/v1/kick", [this](const Call& call, const Reply& reply) { kick(call, reply); });
    post("/api/v1/ban", [this](const Call& call, const Reply& reply) { ban(call, reply); });
    post("/api/v1/unban", [this](const Call& call, const Reply& reply) { unban(call, reply); });
    post("/api/v1/say", [this](const Call& call, const Reply& reply) { say(call, reply); });
    post("/api/v1/drain", [this](const Call& call, const Reply& reply) { drain(call, reply); });
    post("/api/v1/set", [this](const Call& call, const Reply& reply) { set(call, reply); });
    post("/api/v1/reload", [this](const Call&, const Reply& reply) { reload(reply); });
    post("/api/v1/log-level",
         [this](const Call& call, const Reply& reply) { log_level(call, reply); });
    return out;
}

void AdminApi::kick(const Call& call, const Reply& reply) {
    proto::admin::KickRequest body;
    if (!read_body(call, reply, body) ||
        !good_text(body.reason(), "reason", 0, kMaxReasonBytes, reply)) {
        return;
    }
    session::SessionChoice who;
    who.client = ClientId(body.client());
    who.account = body.account();
    who.name = body.name();
    if ((body.client() != 0) + !who.account.empty() + !who.name.empty() != 1) {
        reply(problem(400, "say whom by exactly one of client, account and name"));
        return;
    }
    const std::string reason = body.reason().empty() ? "kicked by the operator" : body.reason();
    on_network([this, reply, who, reason] {
        const std::size_t count = network_.host().kick(who, reason);
        spdlog::info(
            "admin: kicked {}: {}", count_of_sessions(count), session::printable(reason, 256));
        reply(count > 0 ? done_with("kicked " + count_of_sessions(count), count)
                        : problem(404, "no such session"));
    });
}

void AdminApi::keep_bans(const std::vector<session::AccountBan>& bans,
                         const std::string& text,
                         std::size_t count,
                         const Reply& reply) {
    server_.post([this, bans, text, count, reply] {
        try {
            save_bans(settings_.server.session.state_folder, bans);
            reply(done_with(text, count));
        } catch (const std::exception& error) {
            spdlog::error("admin: {}", error.what());
            reply(problem(500, text + ", but only until the server stops: " + error.what()));
        }
    });
}

void AdminApi::ban(const Call& call, const Reply& reply) {
    proto::admin::BanRequest body;
    if (!read_body(call, reply, body) ||
        !good_text(body.account(), "account", 1, kMaxAccountBytes, reply) ||
        !good_text(body.reason(), "reason", 0, kMaxReasonBytes, reply)) {
        return;
    }
    if (!(body.hours() >= 0.0 && body.hours() <= kMostHours)) {
        reply(problem(400, "hours must be 0 (for ever) to 878400"));
        return;
    }
    session::AccountBan ban;
    ban.account = body.account();
    ban.reason = body.reason();
    ban.until_unix_s =
        body.hours() > 0.0
            ? std::time(nullptr) + static_cast<std::int64_t>(std::ceil(3600.0 * body.hours()))
            : 0;
    on_network([this, reply, ban] {
        const std::size_t count = network_.host().ban(ban);
        spdlog::info("admin: banned account {}: {} ended",
                     session::printable(ban.account),
                     count_of_sessions(count));
        keep_bans(
            network_.host().bans(), "banned; " + count_of_sessions(count) + " ended", count, reply);
    });
}

void AdminApi::unban(const Call& call, const Reply& reply) {
    proto::admin::UnbanRequest body;
    if (!read_body(call, reply, body) ||
        !good_text(body.account(), "account", 1, kMaxAccountBytes, reply)) {
        return;
    }
    on_network([this, reply, account = body.account()] {
        if (!network_.host().unban(account)) {
            reply(problem(404, "the account is not banned"));
            return;
        }
        spdlog::info("admin: unbanned account {}", session::printable(account));
        keep_bans(network_.host().bans(), "unbanned", 0, reply);
    });
}

void AdminApi::bans(const Reply& reply) {
    on_network([this, reply] {
        proto::admin::BanList out;
        for (const session::AccountBan& ban : network_.host().bans()) {
            proto::admin::Ban& to = *out.add_bans();
            to.set_account(ban.account);
            to.set_until_unix_s(static_cast<double>(ban.until_unix_s));
            to.set_reason(ban.reason);
        }
        server_.post([reply, out] { reply(json_response(out)); });
    });
}

void AdminApi::say(const Call& call, const Reply& reply) {
    proto::admin::SayRequest body;
    if (!read_body(call, reply, body) ||
        !good_text(body.text(), "text", 1, kMaxNoticeBytes, reply)) {
        return;
    }
    on_network([this, reply, client = ClientId(body.client()), text = body.text()] {
        const std::size_t count = network_.host().notify(client, text);
        spdlog::info(
            "admin: said to {}: {}", count_of_sessions(count), session::printable(text, 256));
        reply(client && count == 0 ? problem(404, "no such session")
                                   : done_with("said to " + count_of_sessions(count), count));
    });
}

void AdminApi::drain(const Call& call, const Reply& reply) {
    proto::admin::DrainRequest body;
    if (!read_body(call, reply, body)) {
        return;
    }
    if (!(body.grace_s() >= 0.0 && body.grace_s() <= kMostGrace_s)) {
        reply(problem(400, "grace_s must be 0 to 86400"));
        return;
    }
    set_draining();
    on_network([this, reply, grace_s = body.grace_s()] {
        const std::uint32_t count = network_.sessions().sessions;
        spdlog::info("admin: draining {} for at most {} s", count_of_sessions(count), grace_s);
        reply(done_with("draining " + count_of_sessions(count), count));
        actions_.drain(grace_s);
    });
}

AdminDone AdminApi::done(const Reply& reply) {
    return [reply](core::Result<std::string> result) {
        reply(result.ok() ? done_with(*result, 0) : problem(409, result.error()));
    };
}

void AdminApi::set(const Call& call, const Reply& reply) {
    proto::admin::SetRequest body;
    if (!read_body(call, reply, body) ||
        !good_text(body.path(), "path", 1, kMaxReasonBytes, reply) ||
        !good_text(body.value(), "value", 0, kMaxReasonBytes, reply)) {
        return;
    }
    on_network([this, reply, path = body.path(), value = body.value()] {
        actions_.set(path, value, done(reply));
    });
}

void AdminApi::reload(const Reply& reply) {
    on_network([this, reply] { actions_.reload(done(reply)); });
}

void AdminApi::log_level(const Call& call, const Reply& reply) {
    proto::admin::LogLevelRequest body;
    if (!read_body(call, reply, body)) {
        return;
    }
    if (!set_log_level(body.level())) {
        reply(problem(400, "level must be debug, info, warning or error"));
        return;
    }
    spdlog::log(spdlog::get_level(), "admin: the log level is {} now", body.level());
    reply(done_with("the log level is " + body.level() + " now", 0));
}

}  // namespace zoned::app
