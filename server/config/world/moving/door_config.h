// door_config: checks and expands the config's doors and their times.
#pragma once

#include "server/config/text/diagnostics.h"
#include "shared/motion/doors.h"

#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct NamedDoor;

/// In world coordinates, in the order of the config; times rounded to ticks. Mistakes (doubled
/// names, times beyond the period, that overlap or open nothing, a door outside the world) go to
/// `diagnostics`. Numbers must have passed check_ranges.
std::vector<NamedDoor> expand_doors(const proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
