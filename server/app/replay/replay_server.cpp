#include "server/app/replay/replay_server.h"

#include "server/admin/json_body.h"
#include "server/app/admin/admin_files.h"
#include "server/app/admin/spectator_routes.h"
#include "server/app/admin/spectator_scene.h"
#include "server/app/admin/spectator_source.h"
#include "server/app/replay/replay_loop.h"
#include "proto/viewer.pb.h"
#include "shared/core/json.h"

#include <asio/io_context.hpp>
#include <asio/signal_set.hpp>

#include <csignal>
#include <cstdio>
#include <memory>
#include <utility>

namespace zoned::app {

namespace {

admin::AdminResponse json_of(const ReplayState& state) {
    core::JsonWriter json;
    json.begin_object()
        .field("last", state.last)
        .field("tick", state.tick)
        .field("target", state.target)
        .field("fault", state.fault)
        .end_object();
    admin::AdminResponse response;
    response.content_type = "application/json";
    response.body = json.text();
    return response;
}

/// Loop, routes and admin server of one recording.
class ReplayServer {
  public:
    ReplayServer(const config::Settings& settings, const ReplayServerArguments& arguments)
        : settings_(settings),
          loop_(settings, arguments.file, arguments.threads) {}

    core::Result<bool> open(const ReplayServerArguments& arguments) {
        auto opened = loop_.open();
        if (!opened.ok()) {
            return opened;
        }
        admin::AdminSettings server;
        server.port = arguments.port;
        server.token = new_admin_token();
        admin::SpectatorSource source = spectator_source(settings_, loop_);
        source.scene = [this] {
            return scene_json(settings_, loop_.state().last);
        };
        server_ = std::make_unique<admin::AdminServer>(server, routes(), std::move(source));
        server_->start();
        if (arguments.from > 0) {
            loop_.seek(arguments.from);
        }
        loop_.start();
        std::printf("ready admin=%u ticks=%lld\nviewer http://127.0.0.1:%u/#token=%s\n",
                    static_cast<unsigned>(server_->port()),
                    static_cast<long long>(loop_.state().last),
                    static_cast<unsigned>(server_->port()),
                    server.token.c_str());
        std::fflush(stdout);
        return true;
    }

    ReplayState stop() {
        server_->stop();
        loop_.stop();
        return loop_.state();
    }

  private:
    std::vector<admin::AdminRoute> routes() {
        std::vector<admin::AdminRoute> out = page_routes();
        const SpectatorRoutes with{
            settings_,
            loop_,
            [this](std::function<void()> work) { server_->post(std::move(work)); },
            [this](std::function<void(const NetworkSample&)> work) {
                // Nobody is connected to a recording.
                server_->post([work = std::move(work)] { work(NetworkSample{}); });
            }};
        for (admin::AdminRoute& route : spectator_routes(with)) {
            out.push_back(std::move(route));
        }
        out.push_back({"GET",
                       "/api/v1/replay",
                       false,
                       [this](const admin::AdminCall&, const admin::AdminReply& reply) {
                           reply(json_of(loop_.state()));
                       },
                       {"The recording's ticks and the one that is shown"}});
        out.push_back({"POST",
                       "/api/v1/replay",
                       false,
                       [this](const admin::AdminCall& call, const admin::AdminReply& reply) {
                           seek(call, reply);
                       },
                       {"Goes to a tick", proto::viewer::SeekRequest::descriptor()}});
        return out;
    }

    void seek(const admin::AdminCall& call, const admin::AdminReply& reply) {
        proto::viewer::SeekRequest body;
        const auto read = admin::from_json(call.request.body, body);
        const Tick last = loop_.state().last;
        if (!read.ok()) {
            reply(admin::problem(400, read.error()));
        } else if (body.tick() == 0 || body.tick() > last) {
            reply(admin::problem(400, "tick must be 1 to " + std::to_string(last)));
        } else {
            loop_.seek(body.tick());
            reply(json_of(loop_.state()));
        }
    }

    const config::Settings& settings_;
    ReplayLoop loop_;
    std::unique_ptr<admin::AdminServer> server_;
};

}  // namespace

core::Result<bool> serve_replay(config::Settings settings, const ReplayServerArguments& arguments) {
    // A recording may be stopped and slowed down as a world in development may.
    settings.server.session.dev_mode_loopback = true;
    asio::io_context io;
    asio::signal_set signals(io, SIGINT, SIGTERM);
    signals.async_wait([](const asio::error_code&, int) {});
    ReplayServer server(settings, arguments);
    auto opened = server.open(arguments);
    if (!opened.ok()) {
        return opened;
    }
    io.run();
    const ReplayState state = server.stop();
    if (!state.fault.empty()) {
        std::fprintf(stderr, "zoned: %s: %s\n", arguments.file.c_str(), state.fault.c_str());
    }
    return !state.differs;
}

}  // namespace zoned::app
