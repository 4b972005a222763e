// choices: reads and checks the decision trees and planning domains of a config for agents.
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

/// Leash of a guard without one in the config, in radii.
inline constexpr double kLeash = 1.5;

/// Calls `look(condition, path)` for each condition of the tree or domain of a state.
void for_each_choice_condition(
    const proto::config::Config& config,
    const proto::config::State& state,
    const std::function<void(const proto::config::Condition&, const std::string&)>& look);

/// The same for its actions.
void for_each_choice_action(
    const proto::config::Config& config,
    const proto::config::State& state,
    const std::function<void(const proto::config::Action&, const std::string&)>& look);

ai::VariableChange expand_change(const proto::config::Change& change,
                                 const VariableOf& variable_of);

/// Reads all settings of an action: ActionKind, speed and the others.
ai::BrainState expand_action(const proto::config::Config& config,
                             const std::string& name,
                             const proto::config::Action& action,
                             const VariableOf& variable_of);

/// Fills in the choices of an innermost state, where it has any. Unknown names lead nowhere.
void expand_choice(const proto::config::Config& config,
                   const proto::config::State& state,
                   const SenseOf& sense_of,
                   const VariableOf& variable_of,
                   ai::BrainState& out);

/// Checks trees and domains by themselves: names, branches, effects, goals.
void check_choices(const proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
