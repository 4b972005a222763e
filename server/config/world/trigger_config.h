// trigger_config: checks and expands the config's triggers.
#pragma once

#include "server/config/text/diagnostics.h"
#include "server/zone/context/triggers.h"

#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

/// In world coordinates, in the order of the config. Mistakes (doubled names, no size, an unknown
/// type, a box outside the world) go to `diagnostics`. Numbers must have passed check_ranges.
std::vector<zone::Trigger> expand_triggers(const proto::config::Config& config,
                                           const world::TypeTable& types,
                                           Diagnostics& diagnostics);

}  // namespace zoned::config
