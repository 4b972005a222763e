// Config loading: reads a config for a command and prints all mistakes to standard error.
#pragma once

#include "server/config/settings.h"

#include <string>
#include <vector>

namespace zoned::app {

/// False after printing every mistake with line and column.
bool load_or_complain(const std::string& config,
                      const std::vector<std::string>& sets,
                      config::Settings& settings);

}  // namespace zoned::app
