// InputLead: how far ahead of the server's clock a client makes its commands, so that they come in
// time and hardly earlier.
#pragma once

#include <array>
#include <cstddef>

namespace zoned::clock {

/// The lead is what commands need to get to the server. A command whose packet is lost or overtaken
/// comes with a later one, so many ticks later: that counts as its way. Without loss the longest of
/// the last kSamples ways is taken, and more the more they scatter and the fewer are known, so that
/// less than kMissingTarget of the commands come late (of n independent delays the next one exceeds
/// the longest with probability 1 / (n + 1); what is added covers the rest for anything up to
/// exponential tails). With loss so long a lead would be for the rarest of cases: all but
/// kMissingUnderLoss are then to be in time.
///
/// What the server says has the last word: a command that it missed raises the lead by a quarter of
/// a tick, one that came in time lowers it by so much that both balance at the target (Robbins,
/// Monro: A Stochastic Approximation Method, 1951, for a quantile).
///
/// The input clock never jumps: it runs faster or slower than the server's by kSlew at most. Not
/// thread-safe. Times in s.
class InputLead {
  public:
    explicit InputLead(double tick_s) : tick_s_(tick_s) {}

    /// Where the lead begins: half the round trip and a tick, before anything is measured.
    void begin(double rtt_s, double now_s);

    [[nodiscard]] bool begun() const { return begun_; }

    /// A packet's way up took `path_s`, from our estimate of the server's time at sending to the
    /// server's own at arrival; the `late` commands before its newest had not come earlier either.
    /// May be negative when that estimate is off. What took longer than the largest lead is an
    /// outage and says nothing.
    void add_path(double path_s, int late);

    /// Share of the packets up that are lost, 0..1.
    void set_loss(double share) { loss_ = share; }

    /// What the server says of the command for a tick: came too late or not at all, or in time. The
    /// first does not count while the lead still rises, and for a round trip after it (the server
    /// has not seen all of what is done about it), nor while few ways up are known.
    void on_feedback(bool missing, double rtt_s);

    /// Runs the input clock on; the lead now.
    double advance(double now_s);

    [[nodiscard]] double lead_s() const { return lead_; }

    /// Where the lead is going.
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
    double rising_s_ = -1e9;  // when the lead was last below what is wanted
    double loss_ = 0.0;
    double feedback_s_ = 0.0;               // what the server's word adds
    std::array<double, kSamples> paths_{};  // a ring
    std::array<double, kSamples> sorted_{};
    std::size_t count_ = 0;
    std::size_t next_measure_ = 0;
};

}  // namespace zoned::clock
