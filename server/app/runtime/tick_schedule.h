// TickSchedule: decides when ticks run; keeps phase and drops ticks that cannot be caught up.
#pragma once

#include "shared/core/assert.h"
#include "shared/core/ids.h"

#include <cmath>
#include <cstdint>

namespace zoned::app {

/// Pure arithmetic over times that the caller passes (s, one monotonic clock). Tick t is due at
/// server time t * dt. A late server runs up to `max_catch_up` ticks on end. Further ticks are
/// dropped from server time (which then stands still for that while, for all clients alike) and
/// counted.
class TickSchedule {
  public:
    /// `done`: ticks that the world has behind it.
    TickSchedule(double rate_hz, unsigned max_catch_up, double start_s, Tick done = 0)
        : dt_s_(1.0 / rate_hz),
          max_catch_up_(max_catch_up),
          origin_s_(start_s - static_cast<double>(done) / rate_hz),
          done_(done) {
        ZONED_ASSERT(rate_hz > 0.0, "a tick rate is positive");
    }

    /// Server time, s.
    [[nodiscard]] double server_time(double now_s) const { return now_s - origin_s_; }

    /// When the next tick is due, on the caller's clock.
    [[nodiscard]] double next_due() const {
        return origin_s_ + static_cast<double>(done_ + 1) * dt_s_;
    }

    /// True when a tick is to be run now; then count it with ran().
    [[nodiscard]] bool due(double now_s) {
        if (now_s < next_due()) {
            return false;
        }
        const auto behind = static_cast<std::int64_t>(std::floor((now_s - next_due()) / dt_s_));
        if (behind > static_cast<std::int64_t>(max_catch_up_)) {
            const std::int64_t drop = behind - static_cast<std::int64_t>(max_catch_up_);
            origin_s_ += static_cast<double>(drop) * dt_s_;
            dropped_ += static_cast<std::uint64_t>(drop);
        }
        return true;
    }

    void ran() { ++done_; }

    [[nodiscard]] Tick done() const { return done_; }

    [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

    [[nodiscard]] double dt_s() const { return dt_s_; }

  private:
    double dt_s_;
    unsigned max_catch_up_;
    double origin_s_;
    Tick done_;
    std::uint64_t dropped_ = 0;
};

}  // namespace zoned::app
