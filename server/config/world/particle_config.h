// particle_config: checks the particle systems of a config and expands them for zones and clients.
#pragma once

#include "server/config/text/diagnostics.h"

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;

/// Checks names, settings that are missing or without effect, emitters outside the world, and
/// cosmetic systems too large for a client to replay in time.
void check_particles(const proto::config::Config& config, Diagnostics& diagnostics);

/// Sorts the systems into settings.particles (simulated) and settings.cosmetics. An emitter's seed
/// is made from the world's, its own and its place in the config.
void expand_particles(const proto::config::Config& config, Settings& settings);

/// The most particles that all simulated systems of a zone may hold together.
std::size_t most_particles(const Settings& settings);

}  // namespace zoned::config
