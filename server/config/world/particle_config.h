// Particle systems of a config: checks, and what zones and clients need to know of them.
#pragma once

#include "server/config/text/diagnostics.h"

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;

/// Names, what is missing or without effect, emitters outside the world, cosmetic systems that no
/// client could replay in good time.
void check_particles(const proto::config::Config& config, Diagnostics& diagnostics);

/// Sorts the systems into settings.particles (simulated) and settings.cosmetics. An emitter's seed
/// comes of the world's, its own and its place in the config.
void expand_particles(const proto::config::Config& config, Settings& settings);

/// The most particles that all simulated systems of a zone may hold together.
std::size_t most_particles(const Settings& settings);

}  // namespace zoned::config
