// Start log: tells at the start all that is unusual about a server, so that nobody runs it open by
// mistake.
#pragma once

#include "server/config/settings.h"

#include <string>
#include <vector>

namespace zoned::app {

/// One sentence for each: development mode and its rights, addresses that others reach, faults on
/// purpose, certificates made here, logins that need no ticket.
[[nodiscard]] std::vector<std::string> unusual_of(const config::Settings& settings);

void log_start(const config::Settings& settings);

}  // namespace zoned::app
