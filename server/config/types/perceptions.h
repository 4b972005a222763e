// perceptions: reads and checks the targets of agents and how they notice them.
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

/// Perception of the brain's agents. Unknown names are left out.
ai::Perception expand_perception(const proto::config::Config& config,
                                 const proto::config::Brain& brain);

/// Checks the names of types; at `path`.
void check_perception(const proto::config::Config& config,
                      const proto::config::Perception& perception,
                      const std::string& path,
                      Diagnostics& diagnostics);

/// Checks the actions of a brain's states against the perception of its agents; mistakes are
/// reported at `path`.
void check_company(const ai::Brain& brain, const std::string& path, Diagnostics& diagnostics);

}  // namespace zoned::config
