// find_by_name: finds the part of an NPC type that a name in a config refers to.
#pragma once

#include "server/ai/agent/brain/brain.h"

#include <cstdint>
#include <functional>
#include <string>

namespace zoned::proto::config {
class Brain;
class Condition;
class Config;
class Domain;
class State;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Index of the first element of that name, -1: none.
template <class List>
int index_of(const List& list, const std::string& name) {
    for (int i = 0; i < list.size(); ++i) {
        if (list[i].name() == name) {
            return i;
        }
    }
    return -1;
}

/// The sense that a condition reads, among those of the brain in question.
using SenseOf = std::function<ai::SenseIndex(const proto::config::Condition&)>;
/// The variable of that name, among those of the brain in question.
using VariableOf = std::function<std::uint16_t(const std::string&)>;

/// Index of the brain of that name, -1: none.
int find_brain(const proto::config::Config& config, const std::string& name);

/// Index of the variable of that name in a brain, -1: none.
int find_variable(const proto::config::Brain& brain, const std::string& name);

/// Index of the tree or domain of that name, -1: none.
int find_tree(const proto::config::Config& config, const std::string& name);
int find_domain(const proto::config::Config& config, const std::string& name);

/// Index of the policy of that name, -1: none.
int find_policy(const proto::config::Config& config, const std::string& name);

/// Index of the goal, -1: none. Not set: the first.
int find_goal(const proto::config::Domain& domain, const proto::config::State& state);

/// Index of the blend of that name, -1: none.
int find_blend(const proto::config::Config& config, const std::string& name);

/// Index of the point of interest of that name, -1: none.
int find_point_of_interest(const proto::config::Config& config, const std::string& name);

}  // namespace zoned::config
