// Agents: state brains and fuzzy systems of a config, in the form in which agents have them,
// and what is wrong with them.
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

/// Brain `index` with the brains that its states are, and the fuzzy systems that they read.
/// What names nothing that exists leads to a state or sense that does not exist either
/// (ai::state_machine::defects_of finds it); brains within brains end a level below the deepest
/// allowed.
ai::Brain expand_brain(const proto::config::Config& config, int index);

/// All of them, told apart by who runs by itself.
std::vector<ai::Brain> expand_brains(const proto::config::Config& config);

/// Machines: names, states, transitions, thresholds beyond perception, senses, brains as states
/// and cycles of them, states that nobody enters. Call it after check_fuzzy().
void check_brains(const proto::config::Config& config, Diagnostics& diagnostics);

/// Machines that run by themselves: types have them, or no other brain and no behaviour holds
/// them. Ascending.
std::vector<int> root_brains(const proto::config::Config& config);

/// What keeps `sense`, a variable or "SYSTEM.OUTPUT", from being known to agents of brain `root`;
/// empty: they sense it.
std::string why_not_sensed(const proto::config::Config& config, int root, const std::string& sense);

}  // namespace zoned::config
