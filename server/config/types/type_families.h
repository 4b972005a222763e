// type_families: completes types with the settings of their bases, and lists the behaviours of
// each.
#pragma once

#include "server/config/text/diagnostics.h"

#include <map>
#include <string>
#include <vector>

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

/// A behaviour as one type has it.
struct BehaviourUse {
    struct Value {
        double value = 0.0;
        std::string path;  ///< of the setting
        std::string type;  ///< the type that sets it: the type itself, or a base
    };

    std::string name;
    std::string path;  ///< setting in which the type, or its base, named it
    std::map<std::string, Value> set;
};

/// By type, in the order of precedence; empty where a type has no behaviours.
using BehaviourUses = std::vector<std::vector<BehaviourUse>>;

/// Copies into each type the settings that only its bases give. Then removes `base` and
/// `behaviour`: the result is complete. A setting overrides the base's, a list replaces the base's
/// list; behaviours that the base has keep their place and take further values, others come before
/// them. A type that names a brain has no behaviours, and one that names behaviours no brain.
/// Reports unknown bases, types that are their own base, and behaviours named twice.
BehaviourUses resolve_types(proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
