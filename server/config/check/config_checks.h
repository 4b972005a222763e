// config_checks: relations between settings, one function per section; each adds what it finds.
#pragma once

#include "server/config/text/diagnostics.h"

#include <string>
#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct ZoneRegion;

/// The zones of the config (a grid is expanded), index = ZoneId - 1. Reports rectangles without
/// area, overlaps, gaps, doubled names.
std::vector<ZoneRegion> expand_zones(const proto::config::Config& config, Diagnostics& diagnostics);

/// Types: names, shapes, machines, declared limits against abilities.
void check_types(const proto::config::Config& config, Diagnostics& diagnostics);

/// Radii against the ghost margin, levels of detail, quantisation against zones and bounds,
/// silence. `zones` as expanded.
void check_replication(const proto::config::Config& config,
                       const std::vector<ZoneRegion>& zones,
                       Diagnostics& diagnostics);

/// Integrators that cannot move bodies.
void check_physics(const proto::config::Config& config, Diagnostics& diagnostics);

/// Addresses, ports, certificate and key files, rules settings, names that `testing` speaks of.
void check_server(const proto::config::Config& config,
                  const std::vector<ZoneRegion>& zones,
                  Diagnostics& diagnostics);

}  // namespace zoned::config
