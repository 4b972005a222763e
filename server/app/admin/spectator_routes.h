// Spectator routes: the requests of the viewer's page beside its stream.
#pragma once

#include "server/admin/admin_router.h"
#include "server/app/admin/admin_api.h"

namespace zoned::app {

/// The routes need these; all must outlive them.
struct SpectatorRoutes {
    const config::Settings& settings;
    VisitedWorld& loop;
    /// Runs work on the admin server's thread.
    std::function<void(std::function<void()>)> post;
    /// Takes a sample of the network, and goes on with it on the admin server's thread.
    std::function<void(std::function<void(const NetworkSample&)>)> sample_network;
};

/// GET scene/pieces/{id}, inspect/{id}, walkable/{id}, flow/{id}, charts; POST pace; all below
/// /api/v1/.
[[nodiscard]] std::vector<admin::AdminRoute> spectator_routes(const SpectatorRoutes& with);

/// The viewer's own files, and those of the page to play on, which may open a WebSocket to this
/// port (0: to none).
[[nodiscard]] std::vector<admin::AdminRoute> page_routes(std::uint16_t websocket_port = 0);

/// GET play.json, for the page to play on.
[[nodiscard]] admin::AdminRoute play_route(const config::Settings& settings,
                                           std::uint16_t websocket_port);

}  // namespace zoned::app
