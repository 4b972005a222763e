// ConfigError: a mistake in a config, and where it stands.
#pragma once

#include <string>
#include <vector>

namespace zoned::config {

/// One mistake in a config. Line and column count from 1; 0 where the parser does not know them.
struct ConfigError {
    int line = 0;
    int column = 0;
    std::string path;  ///< e.g. "zones.zone[2].max_x_m"
    std::string text;  ///< what is wrong and what would be right
};

/// "FILE:LINE:COLUMN: path: text", one line each.
std::string format_errors(const std::string& file, const std::vector<ConfigError>& errors);

}  // namespace zoned::config
