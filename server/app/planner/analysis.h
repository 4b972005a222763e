// Analysis: what `zoned explain` prints of costs and errors, expected beside actual, and what other
// budgets would change.
#pragma once

#include "server/app/planner/forecast.h"

#include <optional>
#include <string>
#include <vector>

namespace zoned::app {

/// A world that was probed, and its figures.
struct WorldForecast {
    std::vector<PassForecast> zones;  ///< expected, this machine
    std::vector<ErrorForecast> errors;
    double speed = 1.0;               ///< of the machine meanwhile, WorldProbe::speed()
    double bytes_per_client_s = 0.0;  ///< headers and seals counted
};

/// From all that `probe` has summed up since it was cleared.
WorldForecast forecast_world(const config::Settings& settings, const WorldProbe& probe);

/// Sum over all zones and passes, ns a tick.
double total_ns(const std::vector<PassForecast>& zones);

/// Bytes to each client a second, headers and seals counted.
double bytes_per_client_s(const config::Settings& settings, const WorldProbe& probe);

/// The expected errors of a world, and whether its budgets are kept.
std::string errors_text(const config::Settings& settings, const WorldForecast& forecast);

/// A world that has run, from its beginning, and how it was loaded and run.
struct ProbedWorld {
    const std::string& file;
    const std::vector<std::string>& sets;
    const config::Settings& settings;
    ProbeCrowd crowd;
    unsigned ticks = 0;
    std::vector<ZoneSums> sums;                ///< of all ticks, by zone
    std::optional<mailbox::CodecPrice> codec;  ///< given before the first tick
};

/// The same world with all its budgets halved and doubled: its methods that would be others, and
/// its cost by units that are counted in as many ticks.
std::string other_budgets_text(const ProbedWorld& own);

/// The forecast for a machine that was as fast as it was during `after`.
WorldForecast at_speed_of(WorldForecast forecast, const WorldProbe& after);

/// Expected beside actual, pass by pass and error by error; `after` has summed up what came after
/// the forecast. Costs are expected for the machine's speed meanwhile, which others' work changes.
std::string analysis_text(const config::Settings& settings,
                          const WorldForecast& forecast,
                          const WorldProbe& after);
std::string analysis_json(const config::Settings& settings,
                          const WorldForecast& forecast,
                          const WorldProbe& after);

}  // namespace zoned::app
