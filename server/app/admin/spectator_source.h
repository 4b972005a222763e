// Spectator source: fills samples of the world for viewers of the admin server.
#pragma once

#include "server/admin/admin_server.h"
#include "server/app/runtime/visited_world.h"
#include "server/config/settings.h"

namespace zoned::app {

/// Suspended agents that one sample looks at; the next one goes on with the others.
inline constexpr std::uint32_t kWalkersPerSample = 512;
/// Particles that a sample holds; of more every n-th is taken.
inline constexpr std::size_t kMostParticlesShown = 20000;

/// Both must outlive the source. Samples are taken between two ticks and read the world alone.
admin::SpectatorSource spectator_source(const config::Settings& settings, VisitedWorld& loop);

/// Copies the columns of all zones, some walkers, and the layers that `out` names. Allocates
/// nothing where `out` was filled before and the world has not grown.
void fill_sample(const World& world, admin::SpectatorSample& out);

}  // namespace zoned::app
