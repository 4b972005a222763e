// config_checks: checks of relations between settings, one function per section; each adds its
// findings.
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
/// area, overlaps, gaps, duplicate names.
std::vector<ZoneRegion> expand_zones(const proto::config::Config& config, Diagnostics& diagnostics);

/// Types: names, shapes, brains, declared limits against abilities.
void check_types(const proto::config::Config& config, Diagnostics& diagnostics);

/// Radii against the ghost margin, levels of detail, quantisation against zones and bounds,
/// silence. `zones` as expanded.
void check_replication(const proto::config::Config& config,
                       const std::vector<ZoneRegion>& zones,
                       Diagnostics& diagnostics);

/// Integrators that cannot move bodies.
void check_physics(const proto::config::Config& config, Diagnostics& diagnostics);

/// Addresses, ports, certificate and key files, rules settings, names that `testing` refers to.
void check_server(const proto::config::Config& config,
                  const std::vector<ZoneRegion>& zones,
                  Diagnostics& diagnostics);

}  // namespace zoned::config
