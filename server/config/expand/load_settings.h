// load_settings: turns the text of a config into settings, and reports every mistake in it.
#pragma once

#include "server/config/settings.h"
#include "server/config/text/config_error.h"

#include <string>
#include <vector>

namespace zoned::config {

/// Reads a config file, applies `sets` ("path.to.field=value"), checks everything. On mistakes,
/// `errors` holds all of them in order of line, and the result must not be used.
bool load_settings(const std::string& file,
                   const std::vector<std::string>& sets,
                   Settings& settings,
                   std::vector<ConfigError>& errors);

/// The same from text (tests, harness, recordings); messages show `name` instead of a file name.
bool parse_settings(const std::string& text,
                    const std::vector<std::string>& sets,
                    Settings& settings,
                    std::vector<ConfigError>& errors);

}  // namespace zoned::config
