// script_config: reads the script that a config names.
#pragma once

#include "server/config/text/diagnostics.h"
#include "server/scripting/script_settings.h"

#include <optional>
#include <string>

namespace zoned::proto::config {
class Config;
}

namespace zoned::config {

/// Puts the script's source into the config, so that recordings hold it. None where the config has
/// no script, or it cannot be read. Whether it compiles is found out when rules are made of it.
std::optional<scripting::ScriptSettings> load_script(proto::config::Config& config,
                                                     Diagnostics& diagnostics);

/// The script in the canonical text of a good config, which holds its source.
std::optional<scripting::ScriptSettings> script_of(const std::string& config_text);

}  // namespace zoned::config
