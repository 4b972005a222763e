// The requests that change something, each logged.
#include "server/admin/json_body.h"
#include "server/app/admin/admin_api.h"
#include "server/app/admin/admin_figures.h"
#include "server/app/admin/admin_files.h"
#include "server/app/log/log.h"
#include "server/session/login/display_names.h"
#include "proto/admin.pb.h"
#include "shared/core/utf8.h"

#include <asio/post.hpp>

#include <algorithm>
#include <cctype>
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
constexpr std::size_t kMaxFileNameBytes = 100;
constexpr double kMostHours = 24.0 * 366.0 * 100.0;
constexpr double kMostGrace_s = 86400.0;
constexpr double kFarthest_m = 1e7;
/// So many orders wait for an answer of the zones, which comes with the next tick.
constexpr std::size_t kMostOrders = 256;

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

/// False, and replied, when it is no place of world coordinates.
bool good_place(const google::protobuf::RepeatedField<double>& at, const admin::AdminReply& reply) {
    const bool good = at.size() == 3 && std::all_of(at.begin(), at.end(), [](double coordinate) {
                          return std::abs(coordinate) <= kFarthest_m;
                      });
    if (!good) {
        reply(problem(400, "position_m must be three numbers: x, y, z in m, world coordinates"));
    }
    return good;
}

/// False, and replied, when it is no name of a file that an operator may choose; empty is one.
bool good_file_name(const std::string& name, const admin::AdminReply& reply) {
    const bool good = name.size() <= kMaxFileNameBytes && !name.starts_with('.') &&
                      std::all_of(name.begin(), name.end(), [](unsigned char c) {
                          return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-';
                      });
    if (!good) {
        reply(problem(400,
                      "file must be a name without a folder: letters, digits, '.', '_' and '-', up "
                      "to 100, no dot at its start"));
    }
    return good;
}

std::string count_of_sessions(std::size_t count) {
    return std::to_string(count) + (count == 1 ? " session" : " sessions");
}

}  // namespace

std::vector<admin::AdminRoute> AdminApi::orders() {
    std::vector<admin::AdminRoute> out;
    const auto post = [&](const char* path,
                          const char* summary,
                          const google::protobuf::Descriptor* body,
                          void (AdminApi::*handle)(const Call&, const Reply&)) {
        out.push_back(
            {"POST",
             path,
             false,
             [this, handle](const Call& call, const Reply& reply) { (this->*handle)(call, reply); },
             {summary, body, proto::admin::Done::descriptor()}});
    };
    post("/api/v1/kick",
         "End sessions; their clients are told why",
         proto::admin::KickRequest::descriptor(),
         &AdminApi::kick);
    post("/api/v1/ban",
         "End an account's sessions and refuse its logins",
         proto::admin::BanRequest::descriptor(),
         &AdminApi::ban);
    post("/api/v1/unban",
         "Let an account log in again",
         proto::admin::UnbanRequest::descriptor(),
         &AdminApi::unban);
    post("/api/v1/say",
         "Send a text to players, as a reliable event",
         proto::admin::SayRequest::descriptor(),
         &AdminApi::say);
    post("/api/v1/spawn",
         "Put an entity into the world",
         proto::admin::SpawnRequest::descriptor(),
         &AdminApi::spawn);
    post("/api/v1/move",
         "Move an entity, at rest, with all that hangs on it",
         proto::admin::MoveRequest::descriptor(),
         &AdminApi::move);
    post("/api/v1/drain",
         "Take no logins; stop when all have left or the grace is over",
         proto::admin::DrainRequest::descriptor(),
         &AdminApi::drain);
    post("/api/v1/set",
         "Change a setting until the server stops",
         proto::admin::SetRequest::descriptor(),
         &AdminApi::set);
    post("/api/v1/reload",
         "Read the config again; what cannot change live is named",
         nullptr,
         &AdminApi::reload);
    post("/api/v1/record",
         "End the recording of the run, or begin one with the state of the world",
         proto::admin::RecordRequest::descriptor(),
         &AdminApi::record);
    post("/api/v1/snapshot",
         "Write the run up to now into a recording of its own",
         proto::admin::SnapshotRequest::descriptor(),
         &AdminApi::snapshot);
    post("/api/v1/log-level",
         "Change what the log holds, in one area or in all",
         proto::admin::LogLevelRequest::descriptor(),
         &AdminApi::change_log_level);
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
        log_of(LogArea::kAdmin)
            .info("kicked {}: {}", count_of_sessions(count), session::printable(reason, 256));
        reply(count > 0 ? done_with("kicked " + count_of_sessions(count), count)
                        : problem(404, "no such session"));
    });
}

void AdminApi::keep(store::StoreChange change,
                    const std::string& text,
                    std::size_t count,
                    const Reply& reply) {
    store_.change(std::move(change), [this, text, count, reply](const std::string& why_not) {
        server_.post([text, count, reply, why_not] {
            if (why_not.empty()) {
                reply(done_with(text, count));
                return;
            }
            log_of(LogArea::kAdmin).error("not durable: {}: {}", text, why_not);
            reply(problem(500, text + ", but a restart may forget it: " + why_not));
        });
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
        log_of(LogArea::kAdmin)
            .info("banned account {}: {} ended",
                  session::printable(ban.account),
                  count_of_sessions(count));
        keep(store::PutBan{ban.account, ban.until_unix_s, ban.reason},
             "banned; " + count_of_sessions(count) + " ended",
             count,
             reply);
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
        log_of(LogArea::kAdmin).info("unbanned account {}", session::printable(account));
        keep(store::RemoveBan{account}, "unbanned", 0, reply);
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
        log_of(LogArea::kAdmin)
            .info("said to {}: {}", count_of_sessions(count), session::printable(text, 256));
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
        log_of(LogArea::kAdmin)
            .info("draining {} for at most {} s", count_of_sessions(count), grace_s);
        reply(done_with("draining " + count_of_sessions(count), count));
        actions_.drain(grace_s);
    });
}

AdminDone AdminApi::done(const Reply& reply) {
    return [reply](const core::Result<AdminOutcome>& result) {
        if (!result.ok()) {
            reply(problem(409, result.error()));
            return;
        }
        proto::admin::Done out;
        out.set_text(result->text);
        for (const config::SettingChange& change : result->changes) {
            fill_change(change, *out.add_changes());
        }
        reply(json_response(out));
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

void AdminApi::reload(const Call&, const Reply& reply) {
    on_network([this, reply] { actions_.reload(done(reply)); });
}

void AdminApi::record(const Call& call, const Reply& reply) {
    proto::admin::RecordRequest body;
    if (!read_body(call, reply, body) || !good_file_name(body.file(), reply)) {
        return;
    }
    on_network([this, reply, on = body.on(), file = body.file()] {
        actions_.record(on, file, done(reply));
    });
}

void AdminApi::snapshot(const Call& call, const Reply& reply) {
    proto::admin::SnapshotRequest body;
    if (!read_body(call, reply, body) || !good_file_name(body.file(), reply)) {
        return;
    }
    on_network([this, reply, file = body.file()] { actions_.snapshot(file, done(reply)); });
}

void AdminApi::change_log_level(const Call& call, const Reply& reply) {
    proto::admin::LogLevelRequest body;
    if (!read_body(call, reply, body)) {
        return;
    }
    const std::size_t area = config::find_log_area(body.area());
    if (!body.area().empty() && area == config::kLogAreas) {
        reply(problem(400, "area must be one of " + config::log_area_list()));
        return;
    }
    if (!set_log_level(static_cast<LogArea>(area), body.level())) {
        reply(problem(400, "level must be debug, info, warning or error"));
        return;
    }
    const std::string text = "the log level" + (body.area().empty() ? "" : " of " + body.area()) +
                             " is " + body.level() + " now";
    log_of(LogArea::kAdmin).log(log_of(LogArea::kAdmin).level(), "{}", text);
    reply(done_with(text, 0));
}

void AdminApi::spawn(const Call& call, const Reply& reply) {
    proto::admin::SpawnRequest body;
    if (!read_body(call, reply, body) || !good_place(body.position_m(), reply)) {
        return;
    }
    const world::TypeTable& types = settings_.types;
    const auto type = std::find_if(types.begin(), types.end(), [&](const world::EntityType& t) {
        return t.name == body.type() && (t.assembly == 0 || t.part == 0);
    });
    if (type == types.end()) {
        reply(problem(404, "there is no type of that name"));
        return;
    }
    if (!(std::abs(body.yaw_deg()) <= 360.0)) {
        reply(problem(400, "yaw_deg must be -360 to 360"));
        return;
    }
    mailbox::SpawnOrder order;
    order.type = static_cast<TypeIndex>(type - types.begin());
    order.yaw = static_cast<std::uint16_t>(
        static_cast<std::int64_t>(std::llround(body.yaw_deg() / 360.0 * 65536.0)) & 0xFFFF);
    std::copy(body.position_m().begin(), body.position_m().end(), order.position);
    order_zones(order, "spawned a " + type->name, reply);
}

void AdminApi::move(const Call& call, const Reply& reply) {
    proto::admin::MoveRequest body;
    if (!read_body(call, reply, body) || !good_place(body.position_m(), reply)) {
        return;
    }
    if (body.entity() == 0) {
        reply(problem(400, "entity must be the number of an entity, from 1 on"));
        return;
    }
    mailbox::MoveOrder order;
    order.entity = EntityId(body.entity());
    std::copy(body.position_m().begin(), body.position_m().end(), order.position);
    order_zones(order, "moved", reply);
}

template <class Order>
void AdminApi::order_zones(Order order, const std::string& text, const Reply& reply) {
    on_network([this, order, text, reply]() mutable {
        if (orders_.size() >= kMostOrders) {
            reply(problem(503, "too many orders wait for the zones; try again"));
            return;
        }
        order.number = ++last_order_;
        if (!loop_.post(order)) {
            reply(problem(503, "the zones' mailbox is full; try again"));
            return;
        }
        orders_[order.number] = {text, reply};
    });
}

void AdminApi::on_order_done(const mailbox::OrderDone& done) {
    const auto it = orders_.find(done.number);
    if (it == orders_.end()) {
        return;  // of a recording that goes on, or of an earlier run
    }
    const WaitingOrder order = std::move(it->second);
    orders_.erase(it);
    if (!done.refused.empty()) {
        order.reply(problem(404, done.refused));
        return;
    }
    const std::string text = order.text + ": entity " + std::to_string(done.entity.value);
    log_of(LogArea::kAdmin).info("{}", text);
    proto::admin::Done out;
    out.set_text(text);
    out.set_entity(done.entity.value);
    order.reply(json_response(out));
}

}  // namespace zoned::app
