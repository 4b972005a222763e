// Session log: a line for each login, return, leave and refusal.
#pragma once

#include "server/session/host/session_figures.h"

#include <cstdint>
#include <string>

namespace zoned::app {

void log_session(const session::SessionNote& note);

/// "PLAY, AUDIT"; "none" for 0.
[[nodiscard]] std::string rights_text(std::uint32_t rights);

}  // namespace zoned::app
