// platform_config: checks and expands the config's platforms, their stops and their times.
#pragma once

#include "server/config/text/diagnostics.h"

#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct NamedPlatform;

/// In world coordinates, in the order of the config; times in ticks, each piece of the way rounded
/// up. Mistakes (doubled names, a single stop, equal stops, a place outside the world, settings of
/// the other kind of mover) go to `diagnostics`. Numbers must have passed check_ranges.
std::vector<NamedPlatform> expand_platforms(const proto::config::Config& config,
                                            Diagnostics& diagnostics);

}  // namespace zoned::config
