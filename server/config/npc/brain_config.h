// AgentStore: state brains and fuzzy systems of a config, in the form in which agents have them,
// and what is wrong with them.
#pragma once

#include "server/ai/agent/brain.h"
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

/// Names that mean nothing become numbers that mean nothing.
ai::fuzzy::FuzzyDef expand_fuzzy(const proto::config::Fuzzy& fuzzy);

/// Inputs, terms, outputs and rules of one fuzzy system, which is at `path`.
void check_fuzzy_system(const proto::config::Fuzzy& fuzzy,
                        const std::string& path,
                        Diagnostics& diagnostics);

/// Fuzzy systems: names, terms, gaps, rules.
void check_fuzzy(const proto::config::Config& config, Diagnostics& diagnostics);

/// Machines: names, states, transitions, thresholds beyond perception, senses, brains as states
/// and cycles of them, states that nobody enters. Call it after check_fuzzy().
void check_brains(const proto::config::Config& config, Diagnostics& diagnostics);

/// Machines that run by themselves: types have them, or no other brain and no behaviour holds
/// them. Ascending.
std::vector<int> root_brains(const proto::config::Config& config);

/// Index of the brain of that name, -1: none.
int find_brain(const proto::config::Config& config, const std::string& name);

/// What keeps `sense`, a variable or "SYSTEM.OUTPUT", from being known to agents of brain `root`;
/// empty: they sense it.
std::string why_not_sensed(const proto::config::Config& config, int root, const std::string& sense);

/// Index of the variable of that name in a brain, -1: none.
int find_variable(const proto::config::Brain& brain, const std::string& name);

}  // namespace zoned::config
