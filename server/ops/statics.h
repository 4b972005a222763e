// statics: turns boxes, hills and walls of the config into static boxes.
#pragma once

#include "server/ops/diagnostics.h"
#include "proto/config.pb.h"
#include "shared/motion/static_geometry.h"

#include <vector>

namespace zoned::ops {

/// All static boxes in world coordinates, in the order of the config: boxes, hills, walls.
/// Mistakes (a ramp that does not fit on its tread, a wall without length, something outside the
/// world) go to `diagnostics`. Sizes must have passed check_ranges.
std::vector<motion::StaticBox> expand_statics(const proto::Config& config,
                                              Diagnostics& diagnostics);

}  // namespace zoned::ops
