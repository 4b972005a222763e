// Restarts: a parent process that starts a server again when it dies.
#pragma once

#include <functional>

namespace zoned::app {

/// Runs `serve` in a child process, and again at once when a signal ended that or it says kFailed;
/// returns what it says otherwise. SIGTERM, SIGINT and SIGHUP go on to the child; after one of the
/// first two nothing is started again. A server that dies more than ten times within a minute is
/// given up with kFailed. Call it before the process has threads.
int restart_when_it_dies(const std::function<int()>& serve);

}  // namespace zoned::app
