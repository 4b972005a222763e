// surfaces: loads the meshes and heightfields that a config places, and checks them.
#pragma once

#include "server/config/text/diagnostics.h"

#include <cstddef>
#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct SurfaceSettings;

/// What all told surfaces of a world may take in the message that each client gets at login, bytes.
inline constexpr std::size_t kMaxReplicatedBytes = 4U << 20;

/// All surfaces of the config that are good, in its order. Mistakes (a file that is missing,
/// damaged, too large or no geometry, options that its content has no use for or lacks, another
/// SHA-256 than the config asks for, a place outside the world or above what states can carry, more
/// than clients can be told) go to `diagnostics`. Notes the SHA-256 of each file in `config`. File
/// names are taken as they stand; sizes must have passed check_ranges.
std::vector<SurfaceSettings> load_surfaces(proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
