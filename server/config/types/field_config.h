// field_config: the declared fields of a type, from the config.
#pragma once

#include "server/config/text/diagnostics.h"
#include "shared/wire/declared/declared_fields.h"

#include <memory>

namespace zoned::proto::config {
class Config;
class Type;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Kinds, ranges, initial values and names of the fields of all types.
void check_fields(const proto::config::Config& config, Diagnostics& diagnostics);

/// Null: the type declares none, or has mistakes.
std::shared_ptr<const wire::FieldSchema> expand_fields(const proto::config::Config& config,
                                                       const proto::config::Type& type);

}  // namespace zoned::config
