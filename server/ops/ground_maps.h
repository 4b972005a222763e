// Ground maps: whether ways can be planned in the zones of a config.
#pragma once

#include "server/ops/diagnostics.h"
#include "proto/config.pb.h"

#include <vector>

namespace zoned::ops {

/// Where ai.ways is set: reports cells that are too large or too small for a zone. `zones` as
/// expanded.
void check_ground_maps(const proto::Config& config,
                       const std::vector<ZoneRegion>& zones,
                       Diagnostics& diagnostics);

}  // namespace zoned::ops
