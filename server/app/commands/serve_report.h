// Serve report: the counts of loop, network and sessions after a server run, as one JSON file and a
// few log lines.
#pragma once

#include "server/app/runtime/network.h"
#include "server/app/runtime/tick_loop.h"
#include "server/config/settings.h"

#include <string>

namespace zoned::app {

/// CPU time of the process so far, s.
double process_cpu_seconds();

/// Everything that the report is made of; loop and network have stopped. The times are those since
/// the world runs, without its start.
struct ServeFigures {
    const config::Settings& settings;
    const TickLoop& loop;
    const Network& network;
    unsigned threads = 1;
    double seconds = 0.0;
    double cpu_seconds = 0.0;  ///< of the process
};

/// One line: the bytes of state packets since `before`, which becomes the present count; nothing
/// where the meter is off.
void log_traffic(const ServeFigures& figures, wire::TrafficTable& before, double seconds);

void log_summary(const ServeFigures& figures);

/// As JSON.
[[nodiscard]] std::string serve_report(const ServeFigures& figures);

}  // namespace zoned::app
