// Perceptions: whom agents look for and how they notice them, as a config says it.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::proto::config {
class Brain;
class Config;
class Perception;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Of the brain's agents. Names that mean nothing are left out.
ai::Perception expand_perception(const proto::config::Config& config,
                                 const proto::config::Brain& brain);

/// Names of types; at `path`.
void check_perception(const proto::config::Config& config,
                      const proto::config::Perception& perception,
                      const std::string& path,
                      Diagnostics& diagnostics);

/// What the states of a brain do against what its agents perceive; mistakes are reported at
/// `path`.
void check_company(const ai::Brain& brain, const std::string& path, Diagnostics& diagnostics);

}  // namespace zoned::config
