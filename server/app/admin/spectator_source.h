// Spectator source: what viewers of the admin server see: the scene once, and samples of entities.
#pragma once

#include "server/admin/admin_server.h"
#include "server/app/runtime/tick_loop.h"
#include "server/config/settings.h"

#include <string>

namespace zoned::app {

/// Both must outlive the source. Samples are taken between two ticks and read the world alone.
admin::SpectatorSource spectator_source(const config::Settings& settings, TickLoop& loop);

/// World, types, zones and static boxes, as server/admin/viewer/renderer.js reads them.
[[nodiscard]] std::string scene_json(const config::Settings& settings);

/// All entities but ghosts and hidden ones.
[[nodiscard]] admin::SpectatorSample sample_of(const World& world);

}  // namespace zoned::app
