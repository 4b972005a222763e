// Choices: decision trees and planning domains of a config, in the form in which agents have them,
// and what is wrong with them.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/config/npc/find_by_name.h"
#include "server/config/text/diagnostics.h"

#include <functional>
#include <string>

namespace zoned::proto::config {
class Action;
class Change;
class Condition;
class Config;
class Domain;
class State;
}  // namespace zoned::proto::config

namespace zoned::config {

/// A guard that says no leash has one of this many radii.
inline constexpr double kLeash = 1.5;

/// Calls `look(condition, path)` for what the tree or domain of a state reads.
void for_each_choice_condition(
    const proto::config::Config& config,
    const proto::config::State& state,
    const std::function<void(const proto::config::Condition&, const std::string&)>& look);

/// Likewise for its actions.
void for_each_choice_action(
    const proto::config::Config& config,
    const proto::config::State& state,
    const std::function<void(const proto::config::Action&, const std::string&)>& look);

ai::VariableChange expand_change(const proto::config::Change& change,
                                 const VariableOf& variable_of);

/// ActionKind, speed and all else that an action says.
ai::BrainState expand_action(const proto::config::Config& config,
                             const std::string& name,
                             const proto::config::Action& action,
                             const VariableOf& variable_of);

/// Fills in what an innermost state chooses among, where it does. Names that mean nothing lead
/// nowhere.
void expand_choice(const proto::config::Config& config,
                   const proto::config::State& state,
                   const SenseOf& sense_of,
                   const VariableOf& variable_of,
                   ai::BrainState& out);

/// Trees and domains by themselves: names, ways, effects, goals.
void check_choices(const proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
