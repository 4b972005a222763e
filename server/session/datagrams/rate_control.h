// RateControl: estimates the bytes per second that the path to one client carries, from the
// arrivals and losses of datagrams.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace zoned::session {

/// Bytes per second, headers counted.
struct RateSettings {
    double ceiling = 16000.0;  ///< the most that a client may cost; the rate begins here
    double floor = 2000.0;     ///< own state and updates of near entities; never below
    bool on = true;            ///< off: the rate is the ceiling
};

/// Delay-based with a loss-based guard, as Google Congestion Control combines them
/// (draft-ietf-rmcat-gcc-02, sections 5 and 6). One-way delays and their base are as in LEDBAT (RFC
/// 6817, section 2.4.2 and 3.4.1): the base delay is the least of a history, so that clocks need no
/// common zero.
///
/// *Signal.* The queue is the least delay of the newest samples, above the base and above the time
/// that a datagram takes at the capacity last seen. More scatter of the samples (jitter) means more
/// samples and a higher threshold.
///
/// *Down.* Above the threshold the path is full, so the bytes that arrive per second are its
/// capacity. The rate goes below it by so much that the queue is gone in half a second. A sender
/// that does not use its rate does not fill the queue, and is only slowed down a little.
///
/// *Up.* 10 % a second near the capacity last seen, else 60 %.
///
/// *Loss.* A radio link loses datagrams at any rate. So loss counts only above a tenth and above
/// the loss that remained after the last cut. Then the rate goes down to the arrival rate: a queue
/// too short to be felt drops instead.
///
/// *Base.* Where cut after cut leaves the delay as it is, the path has become longer (or others
/// fill its queue): that delay is then the base.
///
/// *Silence.* A second without any feedback halves the rate, and every further one again. With the
/// first feedback it is back at half of its former value.
///
/// Not thread-safe. Times are those of one monotonic clock, s.
class RateControl {
  public:
    explicit RateControl(const RateSettings& settings);

    /// A datagram left. `stamp_us`: the clock that it carries. Sequences ascend.
    void on_sent(std::uint64_t sequence, std::size_t bytes, double now_s, std::uint32_t stamp_us);

    /// The client's report of arrivals: the newest, bits for the 32 before, and the client's clock
    /// at the arrival of the newest less its stamp, in 128 us modulo 2^16.
    void on_feedback(std::uint64_t newest,
                     std::uint32_t bits,
                     std::uint16_t one_way_128us,
                     double rtt_s,
                     double now_s);

    /// True when the rate was halved because datagrams leave and no feedback comes.
    bool on_silence(double now_s);

    /// Moves the time since which no feedback came by a stall of this process.
    void excuse_stall(double stall_s) { unheard_s_ += unheard_s_ < 0.0 ? 0.0 : stall_s; }

    /// Within floor and ceiling.
    [[nodiscard]] double bytes_per_s() const { return rate_; }

    /// Of the newest feedback, s: delay in queues as estimated.
    [[nodiscard]] double queue_s() const { return queue_s_; }

    /// Share of the newest datagrams that never arrived.
    [[nodiscard]] double loss() const { return loss_; }

    [[nodiscard]] std::uint64_t cuts() const { return cuts_; }

  private:
    struct SentDatagram {
        std::uint64_t sequence = 0;
        double sent_s = 0.0;
        std::uint32_t stamp_us = 0;
        float bytes = 0.0F;
        float burst_bytes = 0.0F;  // with those that left at once before it
        double total_bytes = 0.0;  // of all sent until then, this one included
        bool arrived = false;
        bool judged = false;  // as arrived or lost, for the share of losses
    };

    /// One arrival as the client reported it.
    struct DelaySample {
        double delay_s = 0.0;    // the client's clock less ours
        double bytes = 0.0;      // of this datagram and those that left at once before it
        double capacity = 0.0;   // of the path then, for a base
        double arrival_s = 0.0;  // on the client's clock
        double sent_s = 0.0;
        double arrived_bytes = 0.0;  // of all until then
        double sent_bytes = 0.0;     // of all until then
    };

    static constexpr std::size_t kSent = 128;
    static constexpr std::size_t kSamples = 24;
    static constexpr std::size_t kBases = 6;

    [[nodiscard]] const DelaySample& back(std::size_t i) const {
        return samples_[(sampled_ - 1 - i) % kSamples];
    }

    double note_arrivals(std::uint64_t newest, std::uint32_t bits);
    void judge_losses(std::uint64_t newest);
    double unwrapped_delay_s(const SentDatagram& sent, std::uint16_t one_way_128us);
    void note_base(const DelaySample& sample, double now_s);
    void measure_queue();
    [[nodiscard]] std::size_t samples_wanted(double scatter) const;
    [[nodiscard]] double less_transmission_s(const DelaySample& sample) const;
    [[nodiscard]] double base_s(const DelaySample& sample) const;
    [[nodiscard]] double scatter_s() const;
    void measure_rates(double window_s);
    void decide(double rtt_s, double now_s);
    void take_base(double now_s);
    void answer_delay(double now_s);
    void answer_loss(double now_s);
    [[nodiscard]] bool lossy() const;
    [[nodiscard]] bool loses_ground() const;
    [[nodiscard]] bool uses_its_rate() const;
    void cut(double to, double now_s);
    void grow(double dt_s);

    RateSettings settings_;
    double rate_;
    std::array<SentDatagram, kSent> sent_{};
    std::uint64_t newest_sent_ = 0;
    std::uint64_t newest_heard_ = 0;
    std::uint64_t reported_newest_ = 0;  // of all reports
    std::uint64_t reported_ = 0;         // bit i: reported_newest_ - i has arrived
    double sent_bytes_ = 0.0;
    double arrived_bytes_ = 0.0;
    std::array<DelaySample, kSamples> samples_{};
    std::size_t sampled_ = 0;
    bool anchored_ = false;
    std::uint32_t anchor_us_ = 0;  // origin of delays, before unwrapping
    double anchor_delay_s_ = 0.0;
    std::array<DelaySample, kBases> bases_{};  // with the least delay of each period
    std::size_t base_periods_ = 0;             // begun so far; the newest is last modulo kBases
    double base_period_s_ = 0.0;               // when the newest period began
    double queue_s_ = 0.0;
    double threshold_s_ = 0.0;
    double usual_scatter_s_ = 0.0;
    double delivered_ = 0.0;  // bytes per second that arrived lately
    double offered_ = 0.0;    // that were sent lately
    double capacity_ = 0.0;   // most that arrived per second since the path was full; 0: never full
    double full_at_ = 0.0;    // arrivals per second at the newest cut
    double loss_ = 0.0;
    double loss_floor_ = 0.0;  // remained whatever the rate
    double clear_loss_ = 0.0;  // while the queue was short
    double loss_at_cut_ = 0.0;
    double loss_cut_s_ = -1e9;
    std::uint64_t loss_from_ = 0;  // sequences from here on tell of the present rate
    double cut_s_ = -1e9;
    double low_s_ = 1e18;      // when the queue was last short
    double cut_hold_s_ = 0.0;  // how long the newest cut needs to show
    int cuts_in_row_ = 0;
    int futile_ = 0;  // cuts in a row that left the delay as it was
    double queue_at_cut_s_ = 0.0;
    double heard_s_ = -1.0;        // newest feedback; below 0: none yet
    double unheard_s_ = -1.0;      // what was sent first since; below 0: nothing
    double silenced_s_ = -1e9;     // newest halving
    double before_silence_ = 0.0;  // the rate; 0: nothing was halved since something was heard
    std::uint64_t cuts_ = 0;
};

}  // namespace zoned::session
