// Shared environment: the config's clocks and variables, checked and expanded.
#pragma once

#include "server/config/text/diagnostics.h"
#include "proto/config.pb.h"
#include "shared/clock/shared_environment.h"

namespace zoned::config {

/// Names are unique among clocks and variables, phases last from min to max.
void check_shared_environment(const proto::Config& config, Diagnostics& diagnostics);

clock::EnvironmentDefs expand_shared_environment(const proto::Config& config);

}  // namespace zoned::config
