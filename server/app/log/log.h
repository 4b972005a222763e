// Log: the server's log by area, as text or JSON, on standard error, written by a thread of its
// own.
#pragma once

#include "server/config/server_settings.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/logger.h>

#include <cstdint>
#include <iosfwd>
#include <string>

namespace zoned::app {

using config::LogArea;

/// Lines that were not written so far.
struct LogCounts {
    std::uint64_t left_out = 0;  ///< beyond LogSettings::lines_per_s
    std::uint64_t dropped = 0;   ///< for want of room in the queue: the terminal or pipe is slow
};

/// The log from its construction to its end; one at a time. A thread that logs never waits for the
/// terminal: with a full queue the oldest lines are dropped, and counted.
class Log {
  public:
    /// Writes to standard error, or to `out` (tests).
    explicit Log(const config::LogSettings& settings, std::ostream* out = nullptr);
    /// Writes what waits.
    ~Log();
    Log(const Log&) = delete;
    Log& operator=(const Log&) = delete;

    /// From now on; from any thread.
    static void set_levels(const config::LogSettings& settings);
    [[nodiscard]] static LogCounts counts();
    /// Returns once the lines so far are written; at the latest after a second, for a terminal that
    /// nobody reads.
    static void drain();
};

/// The logger of an area; without a Log it is that of spdlog's default.
[[nodiscard]] spdlog::logger& log_of(LogArea area);

/// "debug", "info", "warning" or "error"; "mixed" where areas differ.
[[nodiscard]] std::string log_level();
[[nodiscard]] std::string log_level_of(LogArea area);
/// Sets the level of one area, or of all (kCount); false for any other text than the four.
bool set_log_level(LogArea area, const std::string& level);

}  // namespace zoned::app
