// ConfigError: a mistake in a config, with its place.
#pragma once

#include <string>
#include <vector>

namespace zoned::config {

/// One mistake in a config. Line and column count from 1; 0 where the parser does not know them.
struct ConfigError {
    int line = 0;
    int column = 0;
    std::string path;  ///< e.g. "zones.zone[2].max_x_m"
    std::string text;  ///< the mistake and its correction
};

/// "FILE:LINE:COLUMN: path: text", one line each.
std::string format_errors(const std::string& file, const std::vector<ConfigError>& errors);

}  // namespace zoned::config
