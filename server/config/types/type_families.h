// Type families: types with all that their bases give them, and the behaviours that each has.
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
        std::string type;  ///< that says so: the type itself, or a base
    };

    std::string name;
    std::string path;  ///< where the type, or its base, named it
    std::map<std::string, Value> set;
};

/// By type, in the order of precedence; empty where a type has no behaviours.
using BehaviourUses = std::vector<std::vector<BehaviourUse>>;

/// Writes into each type what its bases say and it does not, and takes `base` and `behaviour` out:
/// what is left is complete. A setting overrides the base's, a list replaces the base's list;
/// behaviours that the base has keep their place and take further values, others come before them.
/// A type that names a brain has no behaviours, and one that names behaviours no brain.
/// Reports bases that are none, types that are their own base, and behaviours named twice.
BehaviourUses resolve_types(proto::config::Config& config, Diagnostics& diagnostics);

}  // namespace zoned::config
