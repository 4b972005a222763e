// LoopMeter: how late the process that plays the bots serves them.
#pragma once

#include "shared/core/histogram.h"

namespace zoned::measure {

/// The time between two turns of the loop. A bot that is served less than once a tick sends its
/// inputs late and reads its packets late, which looks like a slow server.
class LoopMeter {
  public:
    /// A turn began at `now_s`, s of a monotonic clock.
    void turn(double now_s) {
        if (last_s_ >= 0.0) {
            const double turn_s = now_s - last_s_;
            turn_ms_.add(1e3 * turn_s);
            measured_s_ += turn_s;
            late_s_ += turn_s > kLate_s ? turn_s : 0.0;
        }
        last_s_ = now_s;
    }

    /// The time until the next turn does not count.
    void pause() { last_s_ = -1.0; }

    [[nodiscard]] const core::Histogram& turn_ms() const { return turn_ms_; }

    /// Share of the time that belongs to turns longer than a tick, 0..1.
    [[nodiscard]] double late_share() const {
        return measured_s_ > 0.0 ? late_s_ / measured_s_ : 0.0;
    }

    static constexpr double kLate_s = 1.0 / 30.0;

  private:
    core::Histogram turn_ms_;
    double last_s_ = -1.0;
    double measured_s_ = 0.0;
    double late_s_ = 0.0;
};

}  // namespace zoned::measure
