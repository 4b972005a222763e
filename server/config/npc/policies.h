// policies: loads trained policies and gives them to the brains that use them.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/config/text/diagnostics.h"

#include <memory>
#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Loaded policies by policy of the config; null where one has a mistake.
using Policies = std::vector<std::shared_ptr<const ai::GuardedPolicy>>;

/// Mistakes (names, a file that is missing, damaged, changed, without meaning, or of another
/// SHA-256 than the config asks for) go to `diagnostics`. Notes the SHA-256 of each file in
/// `config`, so that a recording is not replayed with another.
Policies load_policies(proto::config::Config& config, Diagnostics& diagnostics);

/// Fills in the policies of the states of all brains that run by themselves; a variable that a
/// policy reads and a brain lacks is a mistake.
void give_policies(const proto::config::Config& config,
                   const Policies& policies,
                   std::vector<ai::Brain>& brains,
                   Diagnostics& diagnostics);

}  // namespace zoned::config
