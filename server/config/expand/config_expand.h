// config_expand: fills the stages' settings from a Config that has passed the checks.
#pragma once

#include "server/config/settings.h"

namespace zoned::config {

/// Types, brains and the settings of the stages; zones, statics and entities come from elsewhere.
void expand_stages(const proto::config::Config& config, Settings& settings);

}  // namespace zoned::config
