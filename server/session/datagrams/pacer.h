// Pacer: spreads the datagrams of one tick in time, so that they do not meet the path as a burst.
#pragma once

#include <algorithm>
#include <cstddef>

namespace zoned::session {

/// The pacer of one session. It sends at twice the rate of the path (RFC 9002, section 7.7, asks
/// for at least 1.25 times), except for the first datagram's worth. All of a tick has left before
/// the next one.
class Pacer {
  public:
    /// When a datagram of `bytes` that is ready at `now_s` may leave, s: at least `now_s`. Times do
    /// not go back.
    double due_s(double now_s, double bytes, double bytes_per_s, double tick_s) {
        if (now_s - tick_began_s_ > 0.5 * tick_s) {
            tick_began_s_ = now_s;
        }
        const double paced = 2.0 * bytes_per_s;
        const double waiting = std::max(0.0, paid_until_s_ - now_s) * paced;
        const double due = waiting < kFreeBytes ? now_s : paid_until_s_;
        paid_until_s_ = std::max(paid_until_s_, now_s) + bytes / paced;
        return std::max(now_s, std::min(due, tick_began_s_ + kTickShare * tick_s));
    }

    static constexpr double kFreeBytes = 600.0;
    static constexpr double kTickShare = 0.8;  ///< of a tick: until then all must have left

  private:
    double tick_began_s_ = -1e9;
    double paid_until_s_ = -1e9;
};

}  // namespace zoned::session
