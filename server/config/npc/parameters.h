// Parameters: numbers of brains that have a name, and what stands for them in each type.
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

/// By name of a parameter.
using ParameterValues = std::map<std::string, double>;

/// Calls `look` for every setting of `message`, which is at `path`, that a parameter stands for.
using LookAtParameter =
    std::function<void(const google::protobuf::FieldDescriptor* setting,  ///< with the number
                       const std::string& parameter,
                       bool twice,                 ///< the number is given as well
                       const std::string& path)>;  ///< of the companion that ends in _from
void for_each_parameter(const google::protobuf::Message& message,
                        const std::string& path,
                        const LookAtParameter& look);

/// Puts numbers in the place of parameters; those without a value stay.
void put_parameters(const ParameterValues& values, google::protobuf::Message& message);

/// Parameters by themselves: names, bounds; difficulties: names, what they set.
void check_parameters(const proto::config::Config& config, Diagnostics& diagnostics);

/// What the parameters of behaviour `index` are for a type: as the behaviour says, as the type and
/// its bases say, and then as the difficulty of the config says. Reports values without a
/// parameter, or beyond its bounds. Appends to `choices` what holds and who says so.
ParameterValues values_of(const proto::config::Config& config,
                          int index,
                          const std::string& type,
                          const BehaviourUse& use,
                          std::vector<ParameterChoice>& choices,
                          Diagnostics& diagnostics);

/// What holds, as a section of `zoned explain`; empty where no type has behaviours.
std::string parameters_text(const Settings& settings);

}  // namespace zoned::config
