// GatherSchedule: decides when datagrams are read: together, and in time for the tick that needs
// them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace zoned::net {

/// Pure arithmetic over times that the caller passes, s of one monotonic clock. A datagram is of no
/// use before the next tick begins, and a thread that wakes for each one spends more time on waking
/// than on reading. So datagrams wait in the socket, and are read
///
/// - before they could fill a quarter of its buffer, at the rate of late;
/// - so long before the tick is due that reading them, twice as late as ever of late, is done by
///   then; after that at half of the time that remains, again and again; and as they come in the
///   very last moment.
///
/// Each reading has then as much time to spare as it has left until the tick, so that a thread that
/// is woken late still reads in time.
class GatherSchedule {
  public:
    explicit GatherSchedule(std::size_t buffer_bytes)
        : most_waiting_(std::max(1.0, static_cast<double>(buffer_bytes) / (4.0 * kKernelBytes))) {}

    /// Once a tick; `received`: datagrams so far.
    void begin_tick(std::uint64_t received, double now_s) {
        const double since_s = std::max(now_s - tick_s_, kSoonest_s);
        per_s_ = std::max(static_cast<double>(received - received_) / since_s, kForget * per_s_);
        late_s_ *= kForget;
        received_ = received;
        tick_s_ = now_s;
    }

    /// A reading that was to begin at `due_s` was done at `done_s`.
    void note_reading(double due_s, double done_s) {
        late_s_ = std::clamp(done_s - due_s, late_s_, std::max(late_s_, kLatest_s));
    }

    /// Until when datagrams may wait for a tick that is due at `tick_s`; not after `now_s`: not at
    /// all.
    [[nodiscard]] double hold_until(double now_s, double tick_s) const {
        const double left_s = tick_s - now_s;
        if (!are_many(left_s)) {
            return now_s;
        }
        const double spare_s = 2.0 * late_s_ + kSpare_s;
        const double wanted_s = left_s > 2.0 * spare_s ? left_s - spare_s : 0.5 * left_s;
        const double wait_s = std::min(wanted_s, most_waiting_ / per_s_);
        return wait_s >= kSoonest_s ? now_s + wait_s : now_s;
    }

    /// Whether more come in that time than reading them together takes wake-ups.
    [[nodiscard]] bool are_many(double time_s) const { return per_s_ * time_s >= kFew; }

  private:
    static constexpr double kFew = 4.0;
    /// A small datagram takes up to a page of the buffer, by the network driver.
    static constexpr double kKernelBytes = 4096.0;
    static constexpr double kSpare_s = 0.5e-3;
    static constexpr double kSoonest_s = 0.2e-3;  ///< a timer is not worth less
    static constexpr double kLatest_s = 10e-3;    ///< later ones are stalls, which nothing foresees
    static constexpr double kForget = 0.98;

    double most_waiting_;
    std::uint64_t received_ = 0;
    double tick_s_ = 0.0;
    double per_s_ = 0.0;   // datagrams, at most of late
    double late_s_ = 0.0;  // end of a reading after its due time, at most of late
};

}  // namespace zoned::net
