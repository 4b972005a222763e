// ClockSync: estimates the server's clock from round trips; the caller passes the time.
#pragma once

#include "shared/clock/round_trip.h"

#include <array>
#include <cstddef>

namespace zoned::clock {

/// Filters offset samples as NTP's clock filter does (RFC 5905, section 10): a sample is wrong by
/// at most half its round trip, plus what the clocks have drifted apart since; the sample with the
/// least possible error is believed. The offset is stepped by the first samples, and slewed, never
/// stepped, once it has settled. Samples that contradict the believed one by more than a network
/// and honest clocks can explain take its place: it is of a time before the server left ticks out.
/// By much more (a clock was set, the computer slept), they make it settle anew.
///
/// Beside the newest samples the best one of every kBlockS of the last kBlocks is kept: under
/// jitter the shortest round trip among thousands is much shorter than among dozens. The drift
/// makes samples of a minute ago useful: it is a line through the best samples, each weighed by how
/// far its round trip is above the least (Veitch, Ridoux, Korada: Robust Synchronization of
/// Absolute and Difference Clocks over Networks, IEEE/ACM ToN 17(2), 2009, section IV: rate from
/// packets of good quality far apart, as a constant asymmetry cancels), drawn towards no drift by
/// what crystals are known to do, so that few or bad samples change little.
class ClockSync {
  public:
    /// One exchange, all in seconds: request left at `sent_local`, server received it at
    /// `server_receive` and answered at `server_send` (server clock), the answer came at
    /// `received_local`. An impossible exchange (negative round trip) is ignored.
    void add_sample(double sent_local,
                    double server_receive,
                    double server_send,
                    double received_local);

    /// The server's time at local time `local`; meaningless before ready().
    [[nodiscard]] double server_time(double local) const;

    /// True from the first sample on.
    [[nodiscard]] bool ready() const { return count_ > 0; }

    /// Offset in use at the last sample, server time - local time.
    [[nodiscard]] double offset_s() const { return offset_; }

    /// Smoothed round trip without the server's own time.
    [[nodiscard]] double rtt_s() const { return round_trip_.value().smoothed_s; }

    /// The same, with its variation.
    [[nodiscard]] const RoundTrip& round_trip() const { return round_trip_.value(); }

    /// Smallest round trip of the samples kept (the last 32).
    [[nodiscard]] double min_rtt_s() const;

    /// Largest possible error of server_time() at the last sample, for any asymmetry of the path
    /// and any error of the drift. It is the least over all samples of a sum: half the round trip,
    /// the drift since, and the distance of the estimate from the sample's offset. With clocks that
    /// do not drift and a settled offset this is half the smallest round trip.
    [[nodiscard]] double error_bound_s() const;

    /// How much faster the server's clock runs than ours, s/s, within kMaxDrift; 0 before enough is
    /// known.
    [[nodiscard]] double drift() const { return drift_; }

    /// How often contradicting samples made the filter settle anew.
    [[nodiscard]] std::size_t restarts() const { return restarts_; }

    /// Largest drift between the clocks that the filter allows for, s/s.
    static constexpr double kMaxDrift = 100e-6;
    /// How fast the offset follows, s/s: slow enough that the uneven time is not visible.
    static constexpr double kSlew = 0.02;

  private:
    struct ClockSample {
        double offset = 0.0;
        double rtt = 0.0;
        double local = 0.0;
    };

    /// Expected error of the sample's offset, brought forward by the drift, at `local`.
    [[nodiscard]] double doubt(const ClockSample& sample, double local) const;
    /// Largest possible error of it.
    [[nodiscard]] double uncertainty(const ClockSample& sample, double local) const;
    /// The offset at `local` by this sample.
    [[nodiscard]] double forward(const ClockSample& sample, double local) const;
    [[nodiscard]] const ClockSample& best(double local) const;
    void keep(const ClockSample& sample);
    void forget_samples();
    void begin_anew();
    void estimate_drift();

    static constexpr std::size_t kWindow = 32;
    static constexpr std::size_t kBlocks = 16;
    static constexpr double kBlockS = 4.0;
    static constexpr std::size_t kSettling = 8;  // the first samples step the offset
    /// Samples that contradict each other by more mean that a clock was set, s.
    static constexpr double kStep = 0.1;

    std::array<ClockSample, kWindow> samples_{};  // a ring: sample i is at i modulo kWindow
    std::array<ClockSample, kBlocks> blocks_{};   // the best of each block, a ring likewise
    std::size_t block_count_ = 0;
    double block_s_ = 0.0;              // when the newest block began
    double drift_ = 0.0;                // s/s
    double drift_doubt_ = kMaxDrift;    // expected error of it
    std::size_t count_ = 0;             // of samples since the last that were forgotten
    std::size_t settling_ = kSettling;  // samples that step the offset yet
    std::size_t restarts_ = 0;
    double offset_ = 0.0;  // at last_local_
    double target_ = 0.0;  // where the offset is slewed to, likewise; both drift on
    RoundTripEstimator round_trip_;
    double last_local_ = 0.0;
};

}  // namespace zoned::clock
