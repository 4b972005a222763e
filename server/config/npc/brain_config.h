// brain_config: reads and checks the state machines and fuzzy systems of a config for agents.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/config/text/diagnostics.h"

#include <string>
#include <vector>

namespace zoned::proto::config {
class Brain;
class Config;
class Fuzzy;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Brain `index` with the brains of its states, and the fuzzy systems that they read. An unknown
/// name leads to a state or sense that does not exist (ai::state_machine::defects_of finds it).
/// Brains within brains end a level below the deepest allowed.
ai::Brain expand_brain(const proto::config::Config& config, int index);

/// All brains, marked where they run by themselves.
std::vector<ai::Brain> expand_brains(const proto::config::Config& config);

/// Checks brains: names, states, transitions, thresholds beyond perception, senses, brains as
/// states and their cycles, states that are never entered. Call it after check_fuzzy().
void check_brains(const proto::config::Config& config, Diagnostics& diagnostics);

/// Brains that run by themselves: types name them, or no other brain and no behaviour holds them.
/// Ascending.
std::vector<int> root_brains(const proto::config::Config& config);

/// Reason why agents of brain `root` do not know `sense`, a variable or "SYSTEM.OUTPUT"; empty:
/// they sense it.
std::string why_not_sensed(const proto::config::Config& config, int root, const std::string& sense);

}  // namespace zoned::config
