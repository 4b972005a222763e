// Perceptions: whom agents look for and how they notice them, as a config says it.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/config/text/diagnostics.h"
#include "proto/config.pb.h"

#include <string>

namespace zoned::config {

/// Of the brain's agents. Names that mean nothing are left out.
ai::Perception expand_perception(const proto::Config& config, const proto::Config::Brain& brain);

/// Names of types; at `path`.
void check_perception(const proto::Config& config,
                      const proto::Config::Perception& perception,
                      const std::string& path,
                      Diagnostics& diagnostics);

/// What the states of a brain do against what its agents perceive; mistakes are reported at
/// `path`.
void check_company(const ai::Brain& brain, const std::string& path, Diagnostics& diagnostics);

}  // namespace zoned::config
