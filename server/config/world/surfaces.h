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

/// Largest size of all replicated surfaces of a world in the login message of a client, bytes.
inline constexpr std::size_t kMaxReplicatedBytes = 4U << 20;

/// All good surfaces of the config, in its order. Mistakes go to `diagnostics`. A file may be
/// missing, damaged, too large, no geometry, or have another SHA-256 than the config gives. Options
/// may be missing, or not used by its content. A place may be outside the world or above the range
/// of states. All surfaces together may be too large for the login message. Notes the SHA-256 of
/// each file in `config`. File names are taken as they stand; sizes must have passed check_ranges.
std::vector<SurfaceSettings> load_surfaces(proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
