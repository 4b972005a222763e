// parameters: the named numbers of brains, and their values in each type.
#pragma once

#include "server/config/text/diagnostics.h"
#include "server/config/types/type_families.h"

#include <functional>
#include <map>
#include <string>

namespace google::protobuf {
class FieldDescriptor;
class Message;
}  // namespace google::protobuf

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct ParameterChoice;
struct Settings;

/// Values by name of a parameter.
using ParameterValues = std::map<std::string, double>;

/// Calls `look` for every setting of `message`, which is at `path`, that takes a parameter.
using LookAtParameter =
    std::function<void(const google::protobuf::FieldDescriptor* setting,  ///< with the number
                       const std::string& parameter,
                       bool twice,                 ///< the number is given as well
                       const std::string& path)>;  ///< path of the companion that ends in _from
void for_each_parameter(const google::protobuf::Message& message,
                        const std::string& path,
                        const LookAtParameter& look);

/// Replaces parameters by numbers; parameters without a value stay.
void put_parameters(const ParameterValues& values, google::protobuf::Message& message);

/// Checks parameters by themselves (names, bounds) and difficulties (names, settings).
void check_parameters(const proto::config::Config& config, Diagnostics& diagnostics);

/// Parameters of behaviour `index` for a type. The type and its bases override the behaviour, and
/// the config's difficulty overrides them. Reports values without a parameter, or beyond its
/// bounds. Appends each value and its origin to `choices`.
ParameterValues values_of(const proto::config::Config& config,
                          int index,
                          const std::string& type,
                          const BehaviourUse& use,
                          std::vector<ParameterChoice>& choices,
                          Diagnostics& diagnostics);

/// The values in force as a section of `zoned explain`; empty where no type has behaviours.
std::string parameters_text(const Settings& settings);

}  // namespace zoned::config
