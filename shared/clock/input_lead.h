// InputLead: how far ahead of the server's clock a client makes its commands, so that they arrive
// just in time.
#pragma once

#include <array>
#include <cstddef>

namespace zoned::clock {

/// The lead is the time that commands need to get to the server. A command whose packet is lost or
/// overtaken arrives with a later packet, and the extra ticks count as its travel time. Without
/// loss, the lead is the longest of the last kSamples travel times and a margin. The margin grows
/// with their scatter and with fewer samples, so that less than kMissingTarget of the commands come
/// late. (Of n independent delays the next one exceeds the longest with probability 1 / (n + 1);
/// the margin covers the rest for anything up to exponential tails.) With loss, such a lead would
/// be too long for a rare case: there, all but kMissingUnderLoss are to be in time.
///
/// The server's reports have the last word. A missed command raises the lead by a quarter of a
/// tick. A command in time lowers it by an amount that balances both at the target (Robbins, Monro:
/// A Stochastic Approximation Method, 1951, for a quantile).
///
/// The input clock never jumps: it runs faster or slower than the server's by kSlew at most. Not
/// thread-safe. Times in s.
class InputLead {
  public:
    explicit InputLead(double tick_s) : tick_s_(tick_s) {}

    /// Sets the first lead, before anything is measured: half the round trip and a tick.
    void begin(double rtt_s, double now_s);

    [[nodiscard]] bool begun() const { return begun_; }

    /// A packet took `path_s` to the server: from our estimate of the server's time at sending to
    /// the server's own time at arrival. The `late` commands before its newest had not come earlier
    /// either. `path_s` may be negative when that estimate is wrong. A time longer than the largest
    /// lead is an outage and is ignored.
    void add_path(double path_s, int late);

    /// Share of the packets to the server that are lost, 0..1.
    void set_loss(double share) { loss_ = share; }

    /// The server's report on the command for a tick: too late or missing, or in time. A miss is
    /// ignored while the lead still rises, and for a round trip after that: the server has not seen
    /// the full rise yet. It is also ignored while few travel times are known.
    void on_feedback(bool missing, double rtt_s);

    /// Advances the input clock; returns the present lead.
    double advance(double now_s);

    [[nodiscard]] double lead_s() const { return lead_; }

    /// The lead that is aimed at.
    [[nodiscard]] double wanted_s() const { return wanted_; }

    [[nodiscard]] double most_s() const { return kMostTicks * tick_s_; }

    static constexpr std::size_t kSamples = 512;
    static constexpr double kMissingTarget = 0.001;
    static constexpr double kMissingUnderLoss = 0.01;
    static constexpr double kSlew = 0.05;  ///< s/s
    static constexpr int kMostTicks = 24;

  private:
    void measure();

    double tick_s_;
    bool begun_ = false;
    double lead_ = 0.0;
    double wanted_ = 0.0;
    double last_s_ = 0.0;
    double rising_s_ = -1e9;  // when the lead was last below the wanted lead
    double loss_ = 0.0;
    double feedback_s_ = 0.0;               // part of the lead from the server's reports
    std::array<double, kSamples> paths_{};  // a ring
    std::array<double, kSamples> sorted_{};
    std::size_t count_ = 0;
    std::size_t next_measure_ = 0;
};

}  // namespace zoned::clock
