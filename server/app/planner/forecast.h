// Forecast: what a world is expected to cost and how far off it is expected to be, beside what it
// was when it ran on.
#pragma once

#include "server/app/planner/world_probe.h"

#include <string>
#include <vector>

namespace zoned::app {

/// Cost of a pass in a tick, ns of CPU time, mean over all ticks. Negative: it does not run.
using PassForecast = std::array<double, zone::kPasses>;

/// Of a zone that was probed: by its units at the prices of the table, times `speed`, and by the
/// time that they took.
PassForecast forecast_of(const ZoneSums& probed, double speed);

/// The same by the table alone, in ns of the reference machine.
PassForecast priced(const ZoneSums& probed);

/// One kind of error of a world.
struct ErrorForecast {
    std::string name;   ///< "level 0 position"
    std::string unit;   ///< "m", "rad"
    std::string basis;  ///< how it is expected
    double expected = 0.0;
    double promised = 0.0;  ///< what the settings promise
    zone::Pass pass{};      ///< that makes it
};

/// In the same order as actual_errors(), and after these the errors of methods that a budget has
/// chosen, as their trials found them. Kinds that the world does not have are left out of both.
std::vector<ErrorForecast> forecast_errors(const config::Settings& settings,
                                           const WorldProbe& probe);

/// The error that is expected of a pass, "0.05 m": the one that comes nearest to what is promised.
/// "-": none.
std::string error_of_pass(const std::vector<ErrorForecast>& errors, zone::Pass pass);

/// The errors that were measured; negative: nothing of the kind happened.
std::vector<double> actual_errors(const WorldProbe& probe);

}  // namespace zoned::app
