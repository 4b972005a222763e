// ClockSync: estimates the server's clock from round trips; the caller passes the time.
#pragma once

#include <array>
#include <cstddef>

namespace zoned::clock {

/// Filters offset samples as NTP's clock filter does (RFC 5905, section 10): a sample is wrong by
/// at most half its round trip, plus what the clocks have drifted apart since; the one for which
/// this is least is believed. The offset is stepped by the first samples, and slewed, never
/// stepped, once it has settled. Samples that contradict the believed one by more than a network
/// and honest clocks can explain (a clock was set, the machine slept) make it settle anew.
///
/// Beside the newest samples the best one of every kBlockS of the last kBlocks is kept: under
/// jitter the shortest round trip among thousands is much shorter than among dozens. What makes
/// samples of a minute ago useful is the drift: a line through the best samples, each weighed by
/// how far its round trip is above the least (Veitch, Ridoux, Korada: Robust Synchronization of
/// Absolute and Difference Clocks over Networks, IEEE/ACM ToN 17(2), 2009, section IV: rate from
/// packets of good quality far apart, as a constant asymmetry cancels), drawn towards no drift by
/// what crystals are known to do, so that few or bad samples say nothing.
class ClockSync {
  public:
    /// One exchange, all in seconds: request left at `sent_local`, server received it at
    /// `server_receive` and answered at `server_send` (server clock), the answer came at
    /// `received_local`. Nonsense (negative round trip) is ignored.
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
    [[nodiscard]] double rtt_s() const { return rtt_; }

    /// Smallest round trip of the samples kept (the last 32).
    [[nodiscard]] double min_rtt_s() const;

    /// How wrong server_time() can be at the last sample, whatever the asymmetry of the path, and
    /// however wrong the drift is estimated: the least over all samples of half the round trip, the
    /// drift since, and how far the estimate is from what that sample says. With clocks that do not
    /// drift and a settled offset this is half the smallest round trip.
    [[nodiscard]] double error_bound_s() const;

    /// By how much faster than ours the server's clock runs, s/s, within kMaxDrift; 0 before enough
    /// is known.
    [[nodiscard]] double drift() const { return drift_; }

    /// How often contradicting samples made the filter settle anew.
    [[nodiscard]] std::size_t restarts() const { return restarts_; }

    /// The filter allows for clocks that drift apart by so much, s/s.
    static constexpr double kMaxDrift = 100e-6;
    /// How fast the offset follows, s/s: low enough that nobody sees time run unevenly.
    static constexpr double kSlew = 0.02;

  private:
    struct ClockSample {
        double offset = 0.0;
        double rtt = 0.0;
        double local = 0.0;
    };

    /// How wrong the sample's offset, brought forward by the drift, is to be expected at `local`.
    [[nodiscard]] double doubt(const ClockSample& sample, double local) const;
    /// How wrong it can be at most.
    [[nodiscard]] double uncertainty(const ClockSample& sample, double local) const;
    /// What the sample says the offset is at `local`.
    [[nodiscard]] double forward(const ClockSample& sample, double local) const;
    [[nodiscard]] const ClockSample& best(double local) const;
    void keep(const ClockSample& sample);
    void estimate_drift();

    static constexpr std::size_t kWindow = 32;
    static constexpr std::size_t kBlocks = 16;
    static constexpr double kBlockS = 4.0;
    static constexpr std::size_t kSettling = 8;  // samples by which the offset is stepped
    /// Samples may contradict each other by so much before a clock is taken to have been set, s.
    static constexpr double kStep = 0.1;

    std::array<ClockSample, kWindow> samples_{};  // a ring: sample i is at i modulo kWindow
    std::array<ClockSample, kBlocks> blocks_{};   // the best of each block, a ring likewise
    std::size_t block_count_ = 0;
    double block_s_ = 0.0;            // when the newest block began
    double drift_ = 0.0;              // s/s
    double drift_doubt_ = kMaxDrift;  // how wrong that is to be expected
    std::size_t count_ = 0;           // since the filter last started
    std::size_t restarts_ = 0;
    double offset_ = 0.0;  // at last_local_
    double target_ = 0.0;  // where the offset is slewed to, likewise; both drift on
    double rtt_ = 0.0;
    double last_local_ = 0.0;
};

}  // namespace zoned::clock
