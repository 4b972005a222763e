// check_name: checks names in configs, and formats numbers for messages.
#pragma once

#include "server/config/text/diagnostics.h"

#include <string>

namespace zoned::config {

/// printf of two or three numbers, cut at 299 characters.
std::string text_of(const char* format, double a, double b = 0.0, double c = 0.0);

/// Names travel, stand in logs and in paths: letters, digits, '_', '-' and '.' only. Reports a
/// missing or bad name under `path`.name.
bool check_name(const std::string& name,
                const std::string& what,
                const std::string& path,
                Diagnostics& diagnostics);

}  // namespace zoned::config
