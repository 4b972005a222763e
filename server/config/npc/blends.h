// Blends: fuzzy state brains of a config, in the form in which agents have them, and what is
// wrong with them.
#pragma once

#include "server/config/npc/choices.h"
#include "server/config/text/diagnostics.h"
#include "proto/config.pb.h"

#include <string>

namespace zoned::config {

/// Index of the blend of that name, -1: none.
int find_blend(const proto::Config& config, const std::string& name);

/// Fills in the state's choice and actions; `sense_of` gives the sense of an input.
void expand_blend(const proto::Config& config,
                  const proto::Config::Blend& blend,
                  const std::function<ai::SenseIndex(const proto::Config::FuzzyInput&)>& sense_of,
                  const VariableOf& variable_of,
                  ai::BrainState& out);

/// Names, inputs and terms, propositions, states that nothing leads to, actions that cannot be done
/// at the same time.
void check_blends(const proto::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
