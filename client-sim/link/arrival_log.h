// ArrivalLog: when state packets came and which never did; says how old a client's news can be at a
// tick.
#pragma once

#include "shared/core/ids.h"
#include "shared/wire/widening.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace zoned::link {

/// What is known of the news at one tick.
struct UpdateAge {
    double delay_s = 0.0;   ///< largest one-way delay measured around the tick
    double age_s = 0.0;     ///< D of the promised bound: delay + tick (+ resend, or a whole outage)
    bool loss = false;      ///< a packet near the tick never came, or came late
    wire::Widened widened;  ///< the widest bounds that the server has told of for this time
    bool measured = false;  ///< false: no packet around the tick, nothing can be said
    double plain_s = 0.0;   ///< D of what was not lost: without the resend
};

/// Times are server time as the view shows it (an estimate that never goes back); the packet of
/// tick t has the nominal time t * tick_s.
class ArrivalLog {
  public:
    void set_tick_s(double tick_s) { tick_s_ = tick_s; }

    /// A packet that authenticated. Sequences may come in any order, each once.
    void on_packet(std::uint64_t sequence,
                   Tick tick,
                   double arrival_server_s,
                   const wire::Widened& widened = {});

    /// D at tick T by DESIGN's formula: the largest delay within `window_s` around T plus one tick;
    /// where a packet whose news could matter at T was lost, plus a round trip and a tick: from the
    /// loss until the server has given the packet up (wire::resend_timeout_ticks) and sent again.
    /// Across an outage (a gap in the sequence longer than kOutageTicks) news is as old as the
    /// outage.
    [[nodiscard]] UpdateAge at(Tick tick, double rtt_s, double window_s = 2.0) const;

    /// When the packet came, by the time of on_packet(); none where it did not, or too long ago.
    [[nodiscard]] std::optional<double> arrival_s(std::uint64_t sequence) const;

    /// True when a packet sent after it has come, and it has not.
    [[nodiscard]] bool lost(std::uint64_t sequence) const {
        return sequence < newest_ && !arrival_s(sequence);
    }

    /// The widest bounds that the server has told of for what was shown at a tick with news of that
    /// age.
    [[nodiscard]] wire::Widened notified_bounds(Tick tick, const UpdateAge& age) const;

    /// Server tick of the newest packet.
    [[nodiscard]] Tick newest_tick() const { return newest_tick_; }

    [[nodiscard]] std::uint64_t received() const { return received_; }

    /// Sequences passed over and not come since.
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
