// Bottleneck: the slowest link of a network path: a queue in order, served at a byte rate, that
// drops messages while it is full.
#pragma once

#include "shared/core/histogram.h"

#include <cstdint>
#include <deque>
#include <limits>

namespace zoned::link {

/// Traffic through a bottleneck since the last restart of its meter.
struct BottleneckMeter {
    core::Histogram wait_s;       ///< from entering the queue to the beginning of transmission
    std::uint64_t carried = 0;    ///< messages
    std::uint64_t dropped = 0;    ///< found the queue full
    double carried_bytes = 0.0;   ///< headers counted
    double capacity_bytes = 0.0;  ///< that could have been carried

    [[nodiscard]] double utilisation() const {
        return capacity_bytes > 0.0 ? carried_bytes / capacity_bytes : 0.0;
    }
};

/// A single server with deterministic service times and a drop-tail queue. Times never go back.
/// Exact also where the rate changes during a transmission: the rest of the message goes on at the
/// new rate.
class Bottleneck {
  public:
    /// `bytes_per_s` 0: no bottleneck, nothing may be pushed. `queue_s`: a message that would have
    /// to wait for longer than this is dropped.
    Bottleneck(double bytes_per_s, double queue_s);

    [[nodiscard]] bool limits() const { return bytes_per_s_ > 0.0; }

    /// False: dropped. `number` names the message to pop().
    bool push(double now_s, std::uint64_t number, double bytes);

    struct Departure {
        std::uint64_t number = 0;
        double at_s = 0.0;  ///< when its last bit has left
    };

    /// The next message that has left by `now_s`; false when there is none.
    bool pop(double now_s, Departure& out);
    /// When the next message leaves; infinity when none waits.
    [[nodiscard]] double next_s() const;

    /// From `now_s` on; > 0. Departures before it must have been popped.
    void set_rate(double now_s, double bytes_per_s);

    /// How long a message that entered at `now_s` would wait, s.
    [[nodiscard]] double backlog_s(double now_s) const;

    /// Up to `now_s`.
    [[nodiscard]] BottleneckMeter meter(double now_s) const;
    void restart_meter(double now_s);

  private:
    struct QueuedSize {
        std::uint64_t number = 0;
        double entered_s = 0.0;
        double bytes = 0.0;
        double left = 0.0;  // bytes that are still to be sent
        bool begun = false;
    };

    double bytes_per_s_;
    double queue_s_;
    std::deque<QueuedSize> queue_;
    double queued_bytes_ = 0.0;  // unsent bytes of all waiting messages
    double clock_s_ = 0.0;       // all before it is accounted for
    double metered_s_ = 0.0;     // capacity is counted up to here
    BottleneckMeter meter_;
};

}  // namespace zoned::link
