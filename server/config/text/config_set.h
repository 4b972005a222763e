// config_set: `--set path=value` on every setting, and ranges of every field, both by reflection.
#pragma once

#include "server/config/text/diagnostics.h"

#include <string>

namespace google::protobuf {
class Message;
}  // namespace google::protobuf

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Applies one "path=value". Elements of lists are named by index from 0 or by the element's name:
/// "zones.zone[1].name=north", "type[player].mass_kg=70"; the index one past the last appends.
/// A list without index takes comma-separated values. Messages take "{...}" in text format. An
/// empty value clears a setting, and takes an element out of its list. Mistakes go to `diagnostics`
/// with the path.
void apply_set(const std::string& assignment,
               proto::config::Config& config,
               Diagnostics& diagnostics);

/// Reports every number, string length and list length outside the range in its schema
/// (proto/config/), and every number that is not finite. Each reported value is also replaced
/// (numbers by their default or the nearest end, lists that are too long are cut), so that the
/// checks of relations can follow. `complete`: the text was read to its end; otherwise lists may be
/// short without a mistake.
void check_ranges(google::protobuf::Message& config, bool complete, Diagnostics& diagnostics);

}  // namespace zoned::config
