// TickClock: turns seconds into ticks and back; the caller passes the time.
#pragma once

#include "shared/core/assert.h"
#include "shared/core/ids.h"

#include <cmath>

namespace zoned::clock {

/// Tick t happens at t * dt seconds of server time.
class TickClock {
  public:
    explicit TickClock(double rate_hz) : dt_s_(1.0 / rate_hz) {
        ZONED_ASSERT(rate_hz > 0.0, "a tick rate is positive");
    }

    [[nodiscard]] double dt_s() const { return dt_s_; }

    /// The newest tick whose time is not after `time_s`. A tolerance of a nanosecond absorbs
    /// rounding.
    [[nodiscard]] Tick tick_at(double time_s) const {
        return static_cast<Tick>(std::floor((time_s + 1e-9) / dt_s_));
    }

  private:
    double dt_s_;
};

}  // namespace zoned::clock
