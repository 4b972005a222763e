// blends: reads and checks the fuzzy state machines of a config for agents.
#pragma once

#include "server/config/npc/find_by_name.h"
#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::proto::config {
class Blend;
class Config;
class FuzzyInput;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Fills in the state's choice and actions; `sense_of` gives the sense of an input.
void expand_blend(const proto::config::Config& config,
                  const proto::config::Blend& blend,
                  const std::function<ai::SenseIndex(const proto::config::FuzzyInput&)>& sense_of,
                  const VariableOf& variable_of,
                  ai::BrainState& out);

/// Checks names, inputs and terms, propositions, states that nothing leads to, and actions that
/// cannot be done at the same time.
void check_blends(const proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
