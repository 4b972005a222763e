#include "server/app/admin/spectator_routes.h"

#include "server/admin/json_body.h"
#include "server/admin/viewer_assets.h"
#include "server/app/admin/spectator_details.h"
#include "server/app/admin/spectator_scene.h"
#include "server/app/log/log.h"
#include "server/app/runtime/host_settings.h"
#include "proto/viewer.pb.h"
#include "shared/core/json.h"

#include <cmath>
#include <cstdlib>

namespace zoned::app {

namespace {

using admin::AdminCall;
using admin::AdminReply;
using admin::AdminResponse;
using admin::problem;

constexpr unsigned kMostSteps = 1000;
constexpr float kMostReach_m = 200.0F;

AdminResponse content(std::string body, const char* type) {
    AdminResponse response;
    response.content_type = type;
    response.body = std::move(body);
    return response;
}

AdminResponse json_text(std::string body) {
    return content(std::move(body), "application/json");
}

AdminResponse bytes_of(std::string body) {
    return content(std::move(body), "application/octet-stream");
}

/// A finite number of the query, or `otherwise`; false for anything else.
bool query_metres(const AdminCall& call, const char* name, float otherwise, float& out) {
    const auto it = call.query.find(name);
    out = otherwise;
    if (it == call.query.end()) {
        return true;
    }
    char* end = nullptr;
    out = std::strtof(it->second.c_str(), &end);
    return !it->second.empty() && *end == '\0' && std::isfinite(out);
}

/// Looks at the world between two ticks, and replies on the admin server's thread.
void look(const SpectatorRoutes& with,
          const AdminReply& reply,
          std::function<AdminResponse(const World&)> work) {
    const bool waits =
        with.loop.visit([post = with.post, reply, work = std::move(work)](const World& world) {
            post([reply, response = work(world)] { reply(response); });
        });
    if (!waits) {
        reply(problem(503, "too many look at the world at the same time; try again"));
    }
}

void walkable(const SpectatorRoutes& with, const AdminCall& call, const AdminReply& reply) {
    float x = 0.0F;
    float z = 0.0F;
    float reach = 0.0F;
    if (!query_metres(call, "x", 0.0F, x) || !query_metres(call, "z", 0.0F, z) ||
        !query_metres(call, "reach", 60.0F, reach) || reach <= 0.0F || reach > kMostReach_m) {
        reply(problem(400, "x and z are a place in m, reach is up to 200 m"));
        return;
    }
    const ZoneId zone(static_cast<std::uint16_t>(call.id));
    if (call.id > with.settings.zones.size()) {
        reply(problem(404, "there is no such zone"));
        return;
    }
    look(with, reply, [zone, x, z, reach](const World& world) {
        return bytes_of(walkable_lines(world, zone, x, z, reach));
    });
}

void flow(const SpectatorRoutes& with, const AdminCall& call, const AdminReply& reply) {
    float reach = 0.0F;
    if (!query_metres(call, "reach", 60.0F, reach) || reach <= 0.0F || reach > kMostReach_m) {
        reply(problem(400, "reach is up to 200 m"));
        return;
    }
    look(with, reply, [id = call.id, reach](const World& world) {
        return bytes_of(flow_lines(world, EntityId(id), reach));
    });
}

void write_passes(core::JsonWriter& json, const LoopStats& loop) {
    json.key("passes").begin_object();
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        json.field(zone::pass_name(static_cast<zone::Pass>(p)), loop.passes[p].ns);
    }
    json.end_object();
}

void write_bytes(core::JsonWriter& json, const config::Settings& settings, const LoopStats& loop) {
    json.key("bytes").begin_object();
    for (std::size_t r = 0; r < wire::kTrafficReasons; ++r) {
        const std::uint64_t bits = loop.traffic.bits(static_cast<wire::TrafficReason>(r));
        if (bits > 0) {
            json.field(wire::kTrafficReasonNames[r], bits / 8);
        }
    }
    json.end_object().key("bytes_by_type").begin_object();
    for (std::size_t row = 1; row < loop.traffic.rows().size(); ++row) {
        if (row <= settings.types.size()) {
            json.field(settings.types[row - 1].name, loop.traffic.bits_of_row(row) / 8);
        }
    }
    json.end_object();
}

std::string charts_json(const SpectatorRoutes& with,
                        const LoopStats& loop,
                        const NetworkSample& network,
                        const ErrorShares& errors) {
    core::JsonWriter json;
    json.begin_object()
        .field("time_s", loop.published_s)
        .field("ticks", loop.ticks)
        .field("time_scale", with.loop.time_scale())
        .field("tick_ms_p50", loop.wall_ms.percentile(0.5))
        .field("tick_ms_p99", loop.wall_ms.percentile(0.99))
        .field("overruns", loop.overruns)
        .field("entities", loop.entities)
        .field("awake_bodies", loop.awake_bodies)
        .field("sessions", network.host.sessions)
        .field("bytes_in", network.host.bytes_in)
        .field("bytes_out", network.host.bytes_out)
        .field("limit_exceeded", loop.limit_exceeded);
    write_passes(json, loop);
    write_bytes(json, with.settings, loop);
    json.field("rejected", network.host.rejected);
    json.key("errors")
        .begin_object()
        .field("pairs", errors.pairs)
        .field("p50", errors.p50)
        .field("p99", errors.p99)
        .field("max", errors.max)
        .end_object();
    json.key("zones").begin_array();
    for (const ZoneSample& zone : loop.zones) {
        json.begin_object()
            .field("entities", zone.entities)
            .field("awake", zone.awake_bodies)
            .field("viewers", zone.viewers)
            .field("step_ms", 1e-6 * static_cast<double>(zone.step_ns))
            .end_object();
    }
    json.end_array().end_object();
    return json.text();
}

void charts(const SpectatorRoutes& with, const AdminReply& reply) {
    const bool waits = with.loop.visit([with, reply](const World& world) {
        const ErrorShares errors = sample_errors(world);
        with.sample_network([with, reply, errors](const NetworkSample& network) {
            const auto loop = with.loop.published();
            reply(loop ? json_text(charts_json(with, *loop, network, errors))
                       : problem(503, "the first tick has not run yet; try again in a moment"));
        });
    });
    if (!waits) {
        reply(problem(503, "too many look at the world at the same time; try again"));
    }
}

void pace(const SpectatorRoutes& with, const AdminCall& call, const AdminReply& reply) {
    if (!with.settings.server.session.dev_mode_loopback) {
        reply(problem(403,
                      "the world is slowed down or stopped in development mode alone "
                      "(session.dev_mode_loopback)"));
        return;
    }
    proto::viewer::PaceRequest body;
    const auto read = admin::from_json(call.request.body, body);
    if (!read.ok()) {
        reply(problem(400, read.error()));
        return;
    }
    const double scale = body.has_scale() ? body.scale() : with.loop.time_scale();
    if (!(scale >= 0.0 && scale <= kMostTimeScale) || body.steps() > kMostSteps) {
        reply(problem(400, "scale must be 0 to 8, steps 0 to 1000"));
        return;
    }
    if (body.has_scale() && scale != with.loop.time_scale()) {
        log_of(LogArea::kAdmin).info("the world runs at {} times its rate", scale);
        with.loop.set_time_scale(scale);
    }
    if (scale == 0.0) {
        with.loop.step_ticks(body.steps());
    }
    core::JsonWriter json;
    json.begin_object().field("time_scale", scale).end_object();
    reply(json_text(json.text()));
}

/// Nothing but the page's own files may run or be asked.
constexpr std::string_view kOwnFiles = "default-src 'self'; img-src data:; frame-ancestors 'none'";

/// The page to play on compiles a module, and opens the game's WebSocket.
std::string play_policy(std::uint16_t websocket_port) {
    const std::string port = std::to_string(websocket_port);
    return std::string(kOwnFiles) + "; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'" +
           (websocket_port == 0 ? "" : " ws://*:" + port + " wss://*:" + port);
}

admin::AdminRoute file_route(std::string_view path,
                             std::string_view type,
                             std::string_view file,
                             std::string policy) {
    admin::AdminRoute route{"GET",
                            std::string(path),
                            true,
                            [type = std::string(type), file, policy = std::move(policy)](
                                const AdminCall&, const AdminReply& reply) {
                                AdminResponse response = content(std::string(file), "");
                                response.content_type = type;
                                response.headers.emplace_back("Content-Security-Policy", policy);
                                response.headers.emplace_back("Referrer-Policy", "no-referrer");
                                reply(std::move(response));
                            },
                            {}};
    route.doc.summary = "A file of the viewer's page";
    route.doc.answer_type = std::string(type);
    return route;
}

}  // namespace

std::vector<admin::AdminRoute> spectator_routes(const SpectatorRoutes& with) {
    std::vector<admin::AdminRoute> out;
    const auto add =
        [&](const char* method, const char* path, admin::AdminRouteDoc doc, auto handle) {
            out.push_back({method, path, false, handle, std::move(doc)});
        };
    add("GET",
        "/api/v1/scene/pieces/{id}",
        {"A piece of the world's geometry, as the viewer draws it",
         nullptr,
         nullptr,
         {},
         "application/octet-stream"},
        [with](const AdminCall& call, const AdminReply& reply) {
            std::string piece = scene_piece(with.settings, call.id);
            reply(piece.empty() ? problem(404, "the scene has no such piece")
                                : bytes_of(std::move(piece)));
        });
    add("GET",
        "/api/v1/inspect/{id}",
        {"One entity as the viewer shows it: path, senses, radii, what its client was sent"},
        [with](const AdminCall& call, const AdminReply& reply) {
            look(with, reply, [&settings = with.settings, id = call.id](const World& world) {
                std::string details = details_json(settings, world, EntityId(id));
                return details.empty()
                           ? problem(404, "no entity " + std::to_string(id) + " is in the world")
                           : json_text(std::move(details));
            });
        });
    add("GET",
        "/api/v1/walkable/{id}",
        {"Lines of the ground that agents of a zone plan on",
         nullptr,
         nullptr,
         {{"x", "place in the world, m"}, {"z", "place in the world, m"}, {"reach", "up to 200 m"}},
         "application/octet-stream"},
        [with](const AdminCall& call, const AdminReply& reply) { walkable(with, call, reply); });
    add("GET",
        "/api/v1/flow/{id}",
        {"Lines of the flow field that leads to the goal of an entity's agent",
         nullptr,
         nullptr,
         {{"reach", "up to 200 m"}},
         "application/octet-stream"},
        [with](const AdminCall& call, const AdminReply& reply) { flow(with, call, reply); });
    add("GET",
        "/api/v1/charts",
        {"Sums and quantiles for the viewer's charts"},
        [with](const AdminCall&, const AdminReply& reply) { charts(with, reply); });
    add("POST",
        "/api/v1/pace",
        {"Slows down, stops or steps the world, in development alone",
         proto::viewer::PaceRequest::descriptor()},
        [with](const AdminCall& call, const AdminReply& reply) { pace(with, call, reply); });
    return out;
}

std::vector<admin::AdminRoute> page_routes(std::uint16_t websocket_port) {
    std::vector<admin::AdminRoute> out;
    const std::string_view module = admin::web_client_module();
    for (const admin::ViewerAsset& asset : admin::viewer_assets()) {
        if (module.empty() ? asset.path == "/play" : asset.path == "/play_missing") {
            continue;
        }
        const bool missing = asset.path == "/play_missing";
        out.push_back(file_route(
            missing ? "/play" : asset.path,
            asset.type,
            asset.content,
            asset.path == "/play" ? play_policy(websocket_port) : std::string(kOwnFiles)));
    }
    if (!module.empty()) {
        out.push_back(
            file_route("/zoned_client.wasm", "application/wasm", module, std::string(kOwnFiles)));
    }
    return out;
}

admin::AdminRoute play_route(const config::Settings& settings, std::uint16_t websocket_port) {
    const bool tls = !is_loopback_address(settings.server.network.websocket_address);
    return {"GET",
            "/play.json",
            true,
            [text = play_json(settings, websocket_port, tls)](
                const AdminCall&, const AdminReply& reply) { reply(json_text(text)); },
            {"The world as the page to play on must know it"}};
}

}  // namespace zoned::app
