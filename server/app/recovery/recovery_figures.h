// RecoveryFigures: how a world came back, for metrics.
#pragma once

#include "shared/core/ids.h"

#include <cstdint>

namespace zoned::app {

/// Of the last return; zeros: the world has not come back since it began anew.
struct RecoveryFigures {
    std::uint64_t recoveries = 0;  ///< over all its processes
    double seconds = 0.0;          ///< from the start to the tick at which the server had died
    std::uint64_t ticks = 0;       ///< simulated again
    Tick tick = 0;                 ///< after which the world went on
    std::uint64_t sessions = 0;    ///< that clients could come back to
    std::uint64_t elsewhere = 0;   ///< of accounts that were in another world since
};

}  // namespace zoned::app
