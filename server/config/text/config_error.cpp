#include "server/config/text/config_error.h"

namespace zoned::config {

std::string format_errors(const std::string& file, const std::vector<ConfigError>& errors) {
    std::string out;
    for (const ConfigError& error : errors) {
        out += file + ":";
        if (error.line > 0) {
            out += std::to_string(error.line) + ":" + std::to_string(error.column) + ":";
        }
        out += " ";
        if (!error.path.empty()) {
            out += error.path + ": ";
        }
        out += error.text + "\n";
    }
    return out;
}

}  // namespace zoned::config
