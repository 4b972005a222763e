// Doors: the config's doors and their times, checked and expanded.
#pragma once

#include "server/config/text/diagnostics.h"
#include "proto/config.pb.h"
#include "shared/motion/doors.h"

#include <vector>

namespace zoned::config {

/// In world coordinates, in the order of the config; times rounded to ticks. Mistakes (doubled
/// names, times beyond the period, that overlap or open nothing, a door outside the world) go to
/// `diagnostics`. Numbers must have passed check_ranges.
std::vector<NamedDoor> expand_doors(const proto::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
