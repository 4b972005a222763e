#include "server/app/admin/admin_api.h"

#include "server/admin/json_body.h"
#include "server/admin/metrics_text.h"
#include "server/app/admin/admin_figures.h"
#include "server/app/admin/admin_files.h"
#include "server/app/admin/spectator_routes.h"
#include "server/app/admin/spectator_source.h"
#include "server/app/runtime/host_settings.h"
#include "proto/admin.pb.h"

#include <asio/post.hpp>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <utility>

namespace zoned::app {

namespace {

using admin::AdminResponse;
using admin::json_response;
using admin::problem;

/// Without a tick for so long the server counts as dead.
constexpr double kDeadAfter_s = 10.0;
/// How old figures of the tick loop may be.
constexpr double kPublishedAge_s = 5.0;
constexpr std::size_t kMostSessions = 1000;

/// Its own, or that of the sessions.
net::CertificateFiles admin_certificate(const config::Settings& settings) {
    net::CertificateSettings files = tls_settings(settings).certificate;
    if (!settings.server.network.admin_certificate_file.empty()) {
        files.certificate_file = settings.server.network.admin_certificate_file;
        files.key_file = settings.server.network.admin_key_file;
    }
    return net::prepare_certificate(files);
}

admin::AdminSettings admin_settings(const config::Settings& settings) {
    admin::AdminSettings out;
    out.address = settings.server.network.admin_address;
    out.port = settings.server.network.admin_port;
    out.token = admin_token(settings.server.session.state_folder);
    if (!admin_is_local(settings)) {
        const net::CertificateFiles found = admin_certificate(settings);
        out.certificate_file = found.certificate;
        out.key_file = found.key;
    }
    return out;
}

/// `zoned ctl` connects to it from this machine: an address that is none ("all of them") stands for
/// loopback too.
std::string reachable_address(const config::Settings& settings, std::uint16_t port) {
    std::string address = settings.server.network.admin_address;
    const bool tls = !admin_is_local(settings);
    if (address == "0.0.0.0") {
        address = "127.0.0.1";
    } else if (address == "::") {
        address = "::1";
    }
    const bool six = address.find(':') != std::string::npos;
    return std::string(tls ? "https://" : "") + (six ? "[" + address + "]" : address) + ":" +
           std::to_string(port);
}

/// The admin server's own pages as origins, as browsers write them.
std::vector<std::string> own_origins(const config::Settings& settings, std::uint16_t port) {
    const std::string tail = ":" + std::to_string(port);
    const std::string& address = settings.server.network.admin_address;
    if (admin_is_local(settings)) {
        return {"http://127.0.0.1" + tail, "http://localhost" + tail, "http://[::1]" + tail};
    }
    const bool six = address.find(':') != std::string::npos;
    return {"https://" + (six ? "[" + address + "]" : address) + tail};
}

AdminResponse plain(const std::string& text, const char* type = "text/plain; charset=utf-8") {
    AdminResponse response;
    response.content_type = type;
    response.body = text;
    return response;
}

AdminResponse no_figures() {
    return problem(503, "the first tick has not run yet; try again in a moment");
}

/// A number of the query, `otherwise` without one; false for anything but digits.
bool query_number(const admin::AdminCall& call,
                  const char* name,
                  std::uint32_t otherwise,
                  std::uint32_t& out) {
    const auto it = call.query.find(name);
    out = otherwise;
    if (it == call.query.end()) {
        return true;
    }
    const std::string& text = it->second;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
    return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

AdminApi::AdminApi(const config::Settings& settings,
                   TickLoop& loop,
                   asio::io_context& io,
                   Network& network,
                   ServerStore& store,
                   AdminActions actions)
    : settings_(settings),
      loop_(loop),
      io_(io),
      network_(network),
      store_(store),
      actions_(std::move(actions)),
      start_s_(steady_seconds()),
      server_(admin_settings(settings), routes(), spectator_source(settings, loop)) {
    const std::string& folder = settings.server.session.state_folder;
    network_.set_order_done([this](const mailbox::OrderDone& done) { on_order_done(done); });
    if (!admin_is_local(settings)) {
        write_admin_certificate(folder, admin_certificate(settings).certificate);
    }
    write_admin_address(folder, reachable_address(settings, server_.port()));
    asio::post(io, [&network, origins = own_origins(settings, server_.port())] {
        network.allow_origins(origins);
    });
}

void AdminApi::set_waiting(const std::vector<config::SettingChange>& changes) {
    std::vector<config::SettingChange> waiting;
    std::copy_if(changes.begin(), changes.end(), std::back_inserter(waiting), [](const auto& c) {
        return !c.live;
    });
    server_.post([this, waiting = std::move(waiting)]() mutable { waiting_ = std::move(waiting); });
}

void AdminApi::set_draining() {
    draining_.store(true);
}

std::vector<admin::AdminRoute> AdminApi::routes() {
    std::vector<admin::AdminRoute> out = orders();
    for (admin::AdminRoute& route : page_routes(network_.websocket_port())) {
        out.push_back(std::move(route));
    }
    out.push_back(play_route(settings_, network_.websocket_port()));
    add_open_routes(out);
    const auto get = [&](const char* path, admin::AdminRouteDoc doc, auto handle) {
        out.push_back({"GET", path, false, handle, std::move(doc)});
    };
    get("/api/v1/status",
        {"The server at a glance", nullptr, proto::admin::Status::descriptor()},
        [this](const Call&, const Reply& reply) { status(reply); });
    get("/api/v1/sessions",
        {"Clients that are logged in, ascending by number",
         nullptr,
         proto::admin::SessionList::descriptor(),
         {{"after", "only clients with greater numbers"}, {"limit", "at most so many, 1 to 1000"}}},
        [this](const Call& call, const Reply& reply) { sessions(call, reply); });
    get("/api/v1/zones",
        {"Zones, what they hold and what they cost", nullptr, proto::admin::ZoneList::descriptor()},
        [this](const Call&, const Reply& reply) { zones(reply); });
    get("/api/v1/entities/{id}",
        {"One entity, and why its agent does what it does",
         nullptr,
         proto::admin::EntityFigures::descriptor()},
        [this](const Call& call, const Reply& reply) { entity(call.id, reply); });
    get("/api/v1/bans",
        {"Accounts that may not log in", nullptr, proto::admin::BanList::descriptor()},
        [this](const Call&, const Reply& reply) { bans(reply); });
    const SpectatorRoutes with{
        settings_,
        loop_,
        [this](std::function<void()> work) { server_.post(std::move(work)); },
        [this](std::function<void(const NetworkSample&)> work) {
            with_sample(std::move(work));
        }};
    for (admin::AdminRoute& route : spectator_routes(with)) {
        out.push_back(std::move(route));
    }
    return out;
}

/// Monitors ask these without a token.
void AdminApi::add_open_routes(std::vector<admin::AdminRoute>& out) {
    const auto get = [&](const char* path, admin::AdminRouteDoc doc, auto handle) {
        out.push_back({"GET", path, true, handle, std::move(doc)});
    };
    get("/healthz",
        {"Whether the world ticks", nullptr, nullptr, {}, "text/plain"},
        [this](const Call& call, const Reply& reply) { health(call, reply, false); });
    get("/readyz",
        {"Whether logins are taken", nullptr, nullptr, {}, "text/plain"},
        [this](const Call& call, const Reply& reply) { health(call, reply, true); });
    get("/version",
        {"Version of the program", nullptr, proto::admin::VersionFigures::descriptor()},
        [](const Call&, const Reply& reply) {
            proto::admin::VersionFigures version;
            version.set_version(ZONED_VERSION);
            version.set_target(ZONED_TARGET_NAME);
            version.set_protocol_version(session::HostSettings{}.protocol_version);
            reply(json_response(version));
        });
    get("/metrics",
        {"All figures, as Prometheus reads them", nullptr, nullptr, {}, "text/plain"},
        [this](const Call&, const Reply& reply) { metrics(reply); });
}

void AdminApi::on_network(std::function<void()> work) {
    asio::post(io_, std::move(work));
}

void AdminApi::with_sample(std::function<void(const NetworkSample&)> work) {
    on_network([this, work = std::move(work)] {
        const auto sample = std::make_shared<NetworkSample>();
        sample->host = network_.sessions();
        sample->host.rejected = network_.rejected();
        sample->rtt = network_.rtt();
        sample->udp = network_.udp();
        sample->tls = network_.tls();
        sample->web = network_.web();
        sample->websockets = network_.websockets();
        sample->connections = network_.connections();
        sample->held_events = network_.held_output().waiting();
        if (actions_.recovery) {
            sample->recovery = actions_.recovery();
        }
        if (actions_.cluster) {
            sample->cluster = actions_.cluster();
        }
        sample->refused_events = network_.held_output().refused();
        server_.post([sample, work] { work(*sample); });
    });
}

/// A server that hangs is not healthy; one that drains is healthy, but not ready.
void AdminApi::health(const Call&, const Reply& reply, bool ready) {
    const auto loop = loop_.published();
    const double now = steady_seconds();
    if (loop ? now - loop->published_s > kDeadAfter_s
             : ready || now - start_s_ > 6.0 * kDeadAfter_s) {
        reply(loop ? problem(503, "no tick has ended for more than 10 s") : no_figures());
    } else if (ready && draining_.load()) {
        reply(problem(503, "the server is draining: it takes no logins"));
    } else {
        reply(plain("ok\n"));
    }
}

void AdminApi::status(const Reply& reply) {
    with_sample([this, reply](const NetworkSample& sample) {
        const auto loop = loop_.published();
        if (!loop) {
            reply(no_figures());
            return;
        }
        const double now = steady_seconds();
        proto::admin::Status out;
        fill_status({settings_,
                     *loop,
                     sample,
                     server_.stats(),
                     server_.router(),
                     now - start_s_,
                     now,
                     draining_.load(),
                     store_.figures(),
                     waiting_},
                    out);
        reply(json_response(out));
    });
}

void AdminApi::metrics(const Reply& reply) {
    with_sample([this, reply](const NetworkSample& sample) {
        const auto loop = loop_.published();
        if (!loop) {
            reply(no_figures());
            return;
        }
        const double now = steady_seconds();
        reply(plain(metrics_of({settings_,
                                *loop,
                                sample,
                                server_.stats(),
                                server_.router(),
                                now - start_s_,
                                now,
                                draining_.load(),
                                store_.figures(),
                                waiting_}),
                    admin::kMetricsType));
    });
}

void AdminApi::sessions(const Call& call, const Reply& reply) {
    std::uint32_t after = 0;
    std::uint32_t limit = 0;
    if (!query_number(call, "after", 0, after) ||
        !query_number(call, "limit", kMostSessions, limit) || limit == 0 || limit > kMostSessions) {
        reply(problem(400, "after is a client's number, limit is 1 to 1000"));
        return;
    }
    on_network([this, reply, after, limit] {
        const auto found = std::make_shared<std::vector<session::SessionFigures>>(
            network_.host().figures(ClientId(after), limit, steady_seconds()));
        const std::uint32_t total = network_.sessions().sessions;
        server_.post([reply, found, total] {
            proto::admin::SessionList out;
            for (const session::SessionFigures& figures : *found) {
                fill_session(figures, *out.add_sessions());
            }
            out.set_total(total);
            reply(json_response(out));
        });
    });
}

void AdminApi::zones(const Reply& reply) {
    const auto loop = loop_.published();
    if (!loop || steady_seconds() - loop->published_s > kPublishedAge_s) {
        reply(no_figures());
        return;
    }
    proto::admin::ZoneList out;
    fill_zones(settings_, *loop, out);
    reply(json_response(out));
}

void AdminApi::entity(std::uint32_t id, const Reply& reply) {
    const bool waits = loop_.visit([this, id, reply](const World& world) {
        proto::admin::EntityFigures out;
        const bool found = fill_entity(settings_, world, EntityId(id), out);
        server_.post([found, id, reply, out] {
            reply(found ? json_response(out)
                        : problem(404, "no entity " + std::to_string(id) + " is in the world"));
        });
    });
    if (!waits) {
        reply(problem(503, "too many look at entities at the same time; try again"));
    }
}

}  // namespace zoned::app
