// field_config: the declared fields of a type, from the config.
#pragma once

#include "server/config/text/diagnostics.h"
#include "server/world/entity_type.h"
#include "shared/wire/declared/declared_fields.h"

#include <cstddef>
#include <memory>
#include <optional>

namespace zoned::proto::config {
class Config;
class Type;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Kinds, ranges, initial values and names of the fields of all types.
void check_fields(const proto::config::Config& config, Diagnostics& diagnostics);

/// Words that the values of the type's own fields take together.
std::size_t words_of_fields(const proto::config::Type& type);

/// Fields and types of levers.
void check_levers(const proto::config::Config& config, Diagnostics& diagnostics);

/// None: players do not operate the type.
std::optional<world::Lever> expand_lever(const proto::config::Type& type);

/// Sets `out.fields`, the type's own and those of its deformation, and which are which; null where
/// there are none, or the type has mistakes.
void expand_fields(const proto::config::Config& config,
                   const proto::config::Type& type,
                   world::EntityType& out);

}  // namespace zoned::config
