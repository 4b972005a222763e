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

    /// How wrong server_time() can be at the last sample, whatever the asymmetry of the path: half
    /// the believed sample's round trip, its drift since, and what slewing has still to make up.
    /// With clocks that do not drift and a settled offset this is half the smallest round trip.
    [[nodiscard]] double error_bound_s() const;

    /// How often contradicting samples made the filter settle anew.
    [[nodiscard]] std::size_t restarts() const { return restarts_; }

    /// The filter allows for clocks that drift apart by so much, s/s.
    static constexpr double kMaxDrift = 100e-6;
    /// How fast the offset follows, s/s: low enough that nobody sees time run unevenly.
    static constexpr double kSlew = 0.02;

  private:
    struct Sample {
        double offset = 0.0;
        double rtt = 0.0;
        double local = 0.0;
    };

    /// How wrong the sample's offset can be at `local`.
    [[nodiscard]] static double uncertainty(const Sample& sample, double local);
    [[nodiscard]] const Sample& best(double local) const;

    static constexpr std::size_t kWindow = 32;
    static constexpr std::size_t kSettling = 8;  // samples by which the offset is stepped
    /// Samples may contradict each other by so much before a clock is taken to have been set, s.
    static constexpr double kStep = 0.1;

    std::array<Sample, kWindow> samples_{};  // a ring: sample i is at i modulo kWindow
    std::size_t count_ = 0;                  // since the filter last started
    std::size_t restarts_ = 0;
    double offset_ = 0.0;  // at last_local_
    double target_ = 0.0;  // where the offset is slewed to
    double rtt_ = 0.0;
    double last_local_ = 0.0;
};

}  // namespace zoned::clock
