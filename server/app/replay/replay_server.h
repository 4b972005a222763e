// Replay server: shows a recording in the viewer, with a slider over its ticks.
#pragma once

#include "server/config/settings.h"
#include "shared/core/result.h"

#include <cstdint>
#include <string>

namespace zoned::app {

struct ReplayServerArguments {
    std::string file;
    unsigned threads = 1;
    std::uint16_t port = 0;  ///< on loopback; 0: any free one
    std::int64_t from = 0;   ///< first tick that is shown; 0: the first there is
};

/// Prints the viewer's address and serves until a signal. True: no hash differed. Fails where the
/// recording cannot be shown. Throws std::system_error where the port is taken.
core::Result<bool> serve_replay(config::Settings settings, const ReplayServerArguments& arguments);

}  // namespace zoned::app
