// placed_joints: the joints of a config between placed entities.
#pragma once

#include "server/config/text/diagnostics.h"

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

struct Settings;

/// Fills settings.placed_joints. Needs settings.initial, settings.types and settings.assemblies.
/// Reports names that no entity or part has, entities that take no joint, and what read_joint()
/// reports.
void place_joints(const proto::config::Config& config,
                  Settings& settings,
                  Diagnostics& diagnostics);

}  // namespace zoned::config
