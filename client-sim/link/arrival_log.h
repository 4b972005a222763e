// ArrivalLog: the arrivals and losses of state packets; gives the greatest age of a client's
// updates at a tick.
#pragma once

#include "shared/clock/round_trip.h"
#include "shared/core/ids.h"
#include "shared/wire/widening.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace zoned::link {

/// The age of updates at one tick.
struct UpdateAge {
    double delay_s = 0.0;   ///< largest one-way delay measured around the tick
    double age_s = 0.0;     ///< D of the promised bound: delay + tick (+ resend, or a whole outage)
    bool loss = false;      ///< a packet near the tick never came, or came late
    wire::Widened widened;  ///< the widest bounds that the server has sent for this time
    bool measured = false;  ///< false: no packet around the tick, so nothing is known
    double plain_s = 0.0;   ///< D for updates that were not lost: without the resend
};

/// Times are server time as the view shows it: an estimate that goes back in set_back() alone. The
/// packet of tick t has the nominal time t * tick_s.
class ArrivalLog {
  public:
    void set_tick_s(double tick_s) { tick_s_ = tick_s; }

    /// A packet that authenticated. Sequences may come in any order, each once.
    void on_packet(std::uint64_t sequence,
                   Tick tick,
                   double arrival_server_s,
                   const wire::Widened& widened = {});

    /// The view's clock was set back to `server_s`: the delays measured by the old one are
    /// forgotten, and what has come had come by then.
    void set_back(double server_s);

    /// D at tick T by DESIGN's formula: the largest delay within `window_s` around T plus one tick.
    /// A round trip and a tick are added where a packet with updates that matter at T was lost. The
    /// loss counts until the server has given the packet up (wire::resend_timeout_ticks) and sent
    /// again. Across an outage (a gap in the sequence longer than kOutageTicks) updates are as old
    /// as the outage. Where packets from before T were read after it, however long after, updates
    /// are as old as the oldest of these: a stall of this process, or of the path.
    [[nodiscard]] UpdateAge at(Tick tick,
                               const clock::RoundTrip& path,
                               double window_s = 2.0) const;

    /// Arrival of the packet by the time of on_packet(); none where it did not come, or came too
    /// long ago.
    [[nodiscard]] std::optional<double> arrival_s(std::uint64_t sequence) const;

    /// True when a later packet has come and this one has not.
    [[nodiscard]] bool lost(std::uint64_t sequence) const {
        return sequence < newest_ && !arrival_s(sequence);
    }

    /// The widest bounds that the server has sent for the states shown at a tick with updates of
    /// that age.
    [[nodiscard]] wire::Widened notified_bounds(Tick tick, const UpdateAge& age) const;

    /// Server tick of the newest packet.
    [[nodiscard]] Tick newest_tick() const { return newest_tick_; }

    [[nodiscard]] std::uint64_t received() const { return received_; }

    /// Sequences skipped that have not come since.
    [[nodiscard]] std::uint64_t missing() const { return missing_; }

    static constexpr Tick kOutageTicks = 8;

  private:
    struct Arrival {
        Tick tick = 0;
        double arrival_s = 0.0;
        wire::Widened widened;
    };

    /// Consecutive sequences that did not come when the next one did.
    struct SequenceGap {
        std::uint64_t first = 0;
        std::uint64_t last = 0;
        Tick tick_before = 0;
        Tick tick_after = 0;
        double closed_s = 0.0;  // when the packet after it came
        std::uint64_t filled = 0;
    };

    void note_late(std::uint64_t sequence, double arrival_server_s);

    /// By sequence.
    struct SequenceArrival {
        std::uint64_t sequence = 0;
        double arrival_s = 0.0;
    };

    static constexpr std::size_t kArrivals = 256;
    static constexpr std::size_t kGaps = 64;
    double tick_s_ = 1.0 / 30.0;
    std::array<Arrival, kArrivals> arrivals_{};
    std::size_t arrival_count_ = 0;
    std::array<SequenceArrival, kArrivals> places_{};
    std::array<SequenceGap, kGaps> gaps_{};
    std::size_t gap_count_ = 0;
    std::uint64_t newest_ = 0;
    Tick newest_tick_ = 0;
    std::uint64_t received_ = 0;
    std::uint64_t missing_ = 0;
};

}  // namespace zoned::link
