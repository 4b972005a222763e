// instance_config: checks and expands the parts of the map that are there several times.
#pragma once

#include "server/config/text/diagnostics.h"

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;

/// Adds the zones of the copies, what stands in them, and the entities that come when one opens.
/// Takes the spawn points of their areas out of the world's. Last, since it copies what all others
/// have expanded.
void expand_instances(const proto::config::Config& config,
                      Settings& settings,
                      Diagnostics& diagnostics);

}  // namespace zoned::config
