// environment_config: checks and expands the config's shared clocks and variables.
#pragma once

#include "server/config/text/diagnostics.h"
#include "shared/clock/shared_environment.h"

namespace zoned::proto::config {
class Config;
}  // namespace zoned::proto::config

namespace zoned::config {

/// Names are unique among clocks and variables, phases last from min to max.
void check_shared_environment(const proto::config::Config& config, Diagnostics& diagnostics);

clock::EnvironmentDefs expand_shared_environment(const proto::config::Config& config);

}  // namespace zoned::config
