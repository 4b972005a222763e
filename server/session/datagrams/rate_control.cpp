#include "server/session/datagrams/rate_control.h"

#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace zoned::session {

namespace {

constexpr double kUnit_s = 128e-6;        // of one-way delays on the wire
constexpr double kTargetQueue_s = 0.020;  // above it a path without jitter is full
constexpr double kScatterShare = 0.8;     // of the scatter of delays, on top
constexpr double kFalseAlarm = 1e-4;      // of jitter alone, at one feedback
constexpr std::size_t kLeastSamples = 2;
constexpr std::size_t kTrendSamples = 12;
constexpr double kScatterWeight = 1.0 / 32.0;
constexpr double kBurst_s = 0.005;
constexpr double kLongestTransmission_s = 0.06;
constexpr double kRateWindow_s = 0.35;
constexpr double kBasePeriod_s = 5.0;
constexpr double kBackoff = 0.95;     // below capacity, beside the share that drains the queue ...
constexpr double kDrain_s = 0.5;      // ... in this time ...
constexpr double kDeepest = 0.45;     // ... but by no more than this share
constexpr double kMildBackoff = 0.9;  // of a sender that does not use its rate
constexpr double kUsed = 0.7;         // share of the rate that counts as using it
constexpr double kIdleShare = 0.1;
constexpr double kStanding_s = 3.0;
constexpr double kDeepestCut = 0.5;   // of the rate, at once
constexpr double kReaction_s = 0.15;  // beside a round trip: until a cut shows
constexpr double kSlowGrowth = 0.10;  // per second
constexpr double kFastGrowth = 0.60;
constexpr double kNearFrom = 0.75;  // of the capacity last seen
constexpr double kNearTo = 1.10;
constexpr int kFutileCuts = 4;
constexpr double kLossTolerated = 0.10;
constexpr double kLossExcess = 0.08;  // above the loss that no cut helped against
constexpr double kLossWeight = 1.0 / 48.0;
constexpr double kFloorWeight = 1.0 / 1000.0;  // per datagram: how fast a floor is forgotten
constexpr double kLossPatience_s = 2.0;        // beside a round trip: until a cut for loss shows
constexpr std::uint64_t kLateSequences = 10;   // jitter and reordering explain no more
constexpr double kSilence_s = 1.0;

}  // namespace

RateControl::RateControl(const RateSettings& settings)
    : settings_(settings),
      rate_(settings.ceiling) {
    settings_.floor = std::min(settings_.floor, settings_.ceiling);
}

void RateControl::on_sent(std::uint64_t sequence,
                          std::size_t bytes,
                          double now_s,
                          std::uint32_t stamp_us) {
    sent_bytes_ += static_cast<double>(bytes);
    // A datagram that follows at once waits for the one before: together they are one transmission.
    const SentDatagram& before = sent_[newest_sent_ % kSent];
    const bool burst = newest_sent_ != 0 && now_s - before.sent_s < kBurst_s;
    const float together = static_cast<float>(bytes) + (burst ? before.burst_bytes : 0.0F);
    sent_[sequence % kSent] = {
        sequence, now_s, stamp_us, static_cast<float>(bytes), together, sent_bytes_, false, false};
    newest_sent_ = sequence;
    if (unheard_s_ < 0.0) {
        unheard_s_ = now_s;
    }
}

void RateControl::on_feedback(std::uint64_t newest,
                              std::uint32_t bits,
                              std::uint16_t one_way_128us,
                              double rtt_s,
                              double now_s) {
    if (!settings_.on || newest > newest_sent_) {
        return;
    }
    arrived_bytes_ += note_arrivals(newest, bits);
    const SentDatagram& sent = sent_[newest % kSent];
    if (newest <= newest_heard_ || sent.sequence != newest) {
        return;
    }
    newest_heard_ = newest;
    if (before_silence_ > 0.0) {
        // Where nothing came back at all it was an outage, not a queue; but the path may be
        // another.
        rate_ = std::max(rate_, 0.5 * before_silence_);
        before_silence_ = 0.0;
    }
    const double dt_s = heard_s_ < 0.0 ? 0.0 : std::min(0.25, now_s - heard_s_);
    heard_s_ = now_s;
    unheard_s_ = -1.0;
    judge_losses(newest);
    DelaySample sample;
    sample.delay_s = unwrapped_delay_s(sent, one_way_128us);
    sample.bytes = static_cast<double>(sent.burst_bytes);
    sample.sent_s = sent.sent_s;
    sample.arrival_s = sent.sent_s + sample.delay_s;
    sample.arrived_bytes = arrived_bytes_;
    sample.sent_bytes = sent.total_bytes;
    samples_[sampled_++ % kSamples] = sample;
    note_base(sample, now_s);
    measure_queue();
    measure_rates(kRateWindow_s);
    if (capacity_ > 0.0) {
        capacity_ = std::max(capacity_, std::min(delivered_, offered_));
    }
    decide(rtt_s, now_s);
    // While it is being found out whether a cut helped against loss, the rate stays.
    const bool trial = loss_at_cut_ > 0.0 && now_s - loss_cut_s_ < kLossPatience_s;
    if (!lossy() && !trial) {
        grow(dt_s * std::max(0.0, 1.0 - queue_s_ / threshold_s_));
    }
}

/// Bytes that are heard of for the first time. Each report repeats the ones before it: the bits
/// that are new in it are one or two.
double RateControl::note_arrivals(std::uint64_t newest, std::uint32_t bits) {
    const std::uint64_t reported = (std::uint64_t{bits} << 1U) | 1U;  // bit i: newest - i
    std::uint64_t known = 0;
    if (newest >= reported_newest_) {
        const std::uint64_t ahead = newest - reported_newest_;
        known = ahead < 64 ? reported_ << ahead : 0;
        reported_newest_ = newest;
        reported_ = known | reported;
    }
    double bytes = 0.0;
    for (std::uint64_t fresh = reported & ~known; fresh != 0; fresh &= fresh - 1) {
        const auto back = static_cast<std::uint64_t>(std::countr_zero(fresh));
        if (back >= newest) {
            break;
        }
        SentDatagram& sent = sent_[(newest - back) % kSent];
        if (sent.sequence == newest - back && !sent.arrived) {
            sent.arrived = true;
            bytes += static_cast<double>(sent.bytes);
        }
    }
    return bytes;
}

void RateControl::judge_losses(std::uint64_t newest) {
    for (std::uint64_t back = kLateSequences; back < kSent && back < newest; ++back) {
        SentDatagram& sent = sent_[(newest - back) % kSent];
        if (sent.sequence != newest - back || sent.judged) {
            return;
        }
        sent.judged = true;
        if (sent.sequence < loss_from_) {
            continue;
        }
        loss_floor_ += kFloorWeight * (std::min(loss_floor_, loss_) - loss_floor_);
        loss_ += kLossWeight * ((sent.arrived ? 0.0 : 1.0) - loss_);
        if (queue_s_ < 0.5 * threshold_s_) {
            // No queue that is felt drops these.
            clear_loss_ += kLossWeight * ((sent.arrived ? 0.0 : 1.0) - clear_loss_);
        }
    }
}

/// Delays come modulo 2^16 units (8.4 s); they are taken to differ from the one before by less than
/// half of that.
double RateControl::unwrapped_delay_s(const SentDatagram& sent, std::uint16_t one_way_128us) {
    // The client measured against the stamp, which may stand still when ticks are dropped; our own
    // clock at sending does not.
    const auto sent_units = static_cast<std::uint16_t>(
        static_cast<std::uint64_t>(std::floor(sent.sent_s / kUnit_s)) & 0xFFFFU);
    const auto stamp_units = static_cast<std::uint16_t>((sent.stamp_us >> 7U) & 0xFFFFU);
    const auto units = static_cast<std::uint16_t>(one_way_128us + stamp_units - sent_units);
    if (!anchored_) {
        anchored_ = true;
        anchor_us_ = units;
        anchor_delay_s_ = 0.0;
        return 0.0;
    }
    const auto change = static_cast<std::int16_t>(units - static_cast<std::uint16_t>(anchor_us_));
    anchor_us_ = units;
    anchor_delay_s_ += static_cast<double>(change) * kUnit_s;
    return anchor_delay_s_;
}

/// Delays contain the time of transmission, which is long where the path is narrow: large datagrams
/// must not look like a queue. Capacities are uncertain and change; the larger of the one at the
/// time and the present one makes the base too high rather than too low, and so a queue too short
/// rather than too long: the alarm may come late, but not for nothing.
double RateControl::less_transmission_s(const DelaySample& sample) const {
    const double now = capacity_ > 0.0 ? capacity_ : rate_;
    return sample.delay_s -
           std::min(kLongestTransmission_s, sample.bytes / std::max(now, sample.capacity));
}

/// A path that was never full may be far wider than the rate: a large datagram then took no longer
/// than a small one, and what is subtracted for it would make the small ones look like a queue.
double RateControl::base_s(const DelaySample& sample) const {
    return capacity_ > 0.0 ? less_transmission_s(sample) : sample.delay_s;
}

void RateControl::note_base(const DelaySample& sample, double now_s) {
    if (base_periods_ == 0 || now_s - base_period_s_ > kBasePeriod_s) {
        base_period_s_ = now_s;
        bases_[base_periods_++ % kBases] = sample;
    }
    DelaySample& least = bases_[(base_periods_ - 1) % kBases];
    if (base_s(sample) < base_s(least)) {
        least = sample;
    }
    least.capacity = std::max(least.capacity, capacity_ > 0.0 ? capacity_ : rate_);
}

/// Standard deviation of jitter: from second differences, which a queue that grows or shrinks
/// steadily does not have, and from their median, which a corner in its course does not move. For
/// independent delays a second difference has sqrt(6) times their deviation, and the median of its
/// magnitude is 0.674 of that.
double RateControl::scatter_s() const {
    const std::size_t n = std::min(sampled_, kTrendSamples);
    if (n < 5) {
        return 0.0;
    }
    std::array<double, kTrendSamples> delays{};
    for (std::size_t i = 0; i < n; ++i) {
        delays[i] = less_transmission_s(back(i));
    }
    std::array<double, kTrendSamples> bends{};
    for (std::size_t i = 0; i + 2 < n; ++i) {
        bends[i] = std::abs(delays[i] - 2.0 * delays[i + 1] + delays[i + 2]);
    }
    const auto middle = bends.begin() + static_cast<std::ptrdiff_t>((n - 2) / 2);
    std::nth_element(bends.begin(), middle, bends.begin() + static_cast<std::ptrdiff_t>(n - 2));
    return *middle / (0.674 * std::sqrt(6.0));
}

/// So many that jitter alone would hardly ever leave all of them above the threshold. Reckoned for
/// jitter that is spread evenly, over sqrt(12) deviations; where delays crowd near the least, as in
/// queues that are mostly empty, fewer would do.
std::size_t RateControl::samples_wanted(double scatter) const {
    const double above = 1.0 - threshold_s_ / (std::sqrt(12.0) * scatter);
    if (scatter <= 0.0 || above <= 0.0) {
        return kLeastSamples;
    }
    const double wanted = std::ceil(elementary::log(kFalseAlarm) / elementary::log(above));
    return static_cast<std::size_t>(
        std::clamp(wanted, static_cast<double>(kLeastSamples), static_cast<double>(kSamples)));
}

void RateControl::measure_queue() {
    // An estimate from twelve samples is off by a third now and then.
    const double present = scatter_s();
    usual_scatter_s_ += kScatterWeight * (present - usual_scatter_s_);
    const double scatter = std::max(present, usual_scatter_s_);
    threshold_s_ = kTargetQueue_s + kScatterShare * scatter;
    const std::size_t n = std::min(sampled_, samples_wanted(scatter));
    double least = less_transmission_s(back(0));
    for (std::size_t i = 1; i < n; ++i) {
        least = std::min(least, less_transmission_s(back(i)));
    }
    double base = base_s(bases_[0]);
    for (std::size_t i = 1; i < std::min(base_periods_, kBases); ++i) {
        base = std::min(base, base_s(bases_[i]));
    }
    queue_s_ = std::max(0.0, least - base);
}

void RateControl::measure_rates(double window_s) {
    const DelaySample& newest = back(0);
    const std::size_t n = std::min(sampled_, kSamples);
    for (std::size_t i = 1; i < n; ++i) {
        const DelaySample& older = back(i);
        const double arrival_s = newest.arrival_s - older.arrival_s;
        const double sent_s = newest.sent_s - older.sent_s;
        if (std::min(arrival_s, sent_s) >= window_s) {
            delivered_ = (newest.arrived_bytes - older.arrived_bytes) / arrival_s;
            offered_ = (newest.sent_bytes - older.sent_bytes) / sent_s;
            return;
        }
    }
    // Too little is known yet: take the samples there are, if there are any.
    const DelaySample& oldest = back(n - 1);
    if (n > 4 && newest.arrival_s > oldest.arrival_s && newest.sent_s > oldest.sent_s) {
        delivered_ =
            (newest.arrived_bytes - oldest.arrived_bytes) / (newest.arrival_s - oldest.arrival_s);
        offered_ = (newest.sent_bytes - oldest.sent_bytes) / (newest.sent_s - oldest.sent_s);
    }
}

void RateControl::decide(double rtt_s, double now_s) {
    if (queue_s_ < 0.5 * threshold_s_) {
        cuts_in_row_ = 0;
        low_s_ = now_s;
    }
    if (now_s - std::max(low_s_, cut_s_) > kStanding_s) {
        // A queue that is fed grows, and one that is not shrinks: a delay that stays is no queue.
        take_base(now_s);
        low_s_ = now_s;
    }
    // The effect of a cut shows after a round trip.
    const bool shown = now_s - cut_s_ > rtt_s + cut_hold_s_;
    if (shown && delivered_ > 0.0 && queue_s_ > threshold_s_) {
        answer_delay(now_s);
    } else if (now_s - loss_cut_s_ > rtt_s + kLossPatience_s) {
        answer_loss(now_s);
    }
}

void RateControl::answer_delay(double now_s) {
    ++cuts_in_row_;
    futile_ = cuts_in_row_ > 1 && queue_s_ > 0.8 * queue_at_cut_s_ ? futile_ + 1 : 0;
    queue_at_cut_s_ = queue_s_;
    if (futile_ >= kFutileCuts) {
        // Those cuts were for nothing, and the capacity that they assumed was wrong.
        capacity_ = 0.0;
        full_at_ = 0.0;
        take_base(now_s);
        cuts_in_row_ = 0;
        futile_ = 0;
    } else if (uses_its_rate() || loses_ground()) {
        // Later in the row the path may be idle: arrivals then equal the bytes sent, and say
        // nothing of the capacity.
        if (cuts_in_row_ == 1 || std::abs(delivered_ - offered_) > kIdleShare * offered_) {
            capacity_ = delivered_;
        }
        const double drain = std::min(kDeepest, queue_s_ / kDrain_s);
        // Datagrams that are lost at any rate used the path before they were lost.
        const double carried =
            delivered_ / (1.0 - std::min(0.5, std::max(loss_floor_, clear_loss_)));
        cut(std::min(rate_, (kBackoff - drain) * carried), now_s);
        cut_hold_s_ = kReaction_s + std::min(kDrain_s, queue_s_);
    } else {
        cut(kMildBackoff * rate_, now_s);
        cut_hold_s_ = kReaction_s;
    }
}

void RateControl::take_base(double now_s) {
    base_periods_ = 0;
    note_base(back(0), now_s);
}

void RateControl::answer_loss(double now_s) {
    if (loss_at_cut_ > 0.0) {
        if (loss_ > 0.5 * loss_at_cut_) {
            loss_floor_ = std::max(loss_floor_, loss_at_cut_);
        }
        loss_at_cut_ = 0.0;
    }
    if (uses_its_rate() && lossy()) {
        loss_at_cut_ = loss_;
        loss_cut_s_ = now_s;
        loss_from_ = newest_sent_ + 1;
        loss_ = loss_floor_;
        capacity_ = delivered_;
        cut(std::min(rate_, kBackoff * delivered_), now_s);
        cut_hold_s_ = kReaction_s;
    }
}

bool RateControl::lossy() const {
    return loss_ > kLossTolerated && loss_ > loss_floor_ + kLossExcess;
}

/// More is sent than arrives or is lost: the queue is ours. Jitter makes both uncertain.
bool RateControl::loses_ground() const {
    const double scatter_s = (threshold_s_ - kTargetQueue_s) / kScatterShare;
    const double margin = kIdleShare + 2.0 * scatter_s / kRateWindow_s;
    return offered_ * (1.0 - loss_) > (1.0 + margin) * delivered_;
}

bool RateControl::uses_its_rate() const {
    return offered_ > kUsed * rate_;
}

void RateControl::cut(double to, double now_s) {
    // The arrival rate is measured over few datagrams: one bad sample must not starve a client.
    rate_ = std::clamp(std::max(to, kDeepestCut * rate_), settings_.floor, settings_.ceiling);
    full_at_ = capacity_;
    cut_s_ = now_s;
    ++cuts_;
}

void RateControl::grow(double dt_s) {
    const bool near = full_at_ > 0.0 && rate_ > kNearFrom * full_at_ && rate_ < kNearTo * full_at_;
    if (full_at_ > 0.0 && rate_ >= kNearTo * full_at_ && !uses_its_rate()) {
        return;  // beyond the path's known capacity only a rate in use can be tried
    }
    rate_ = std::min(settings_.ceiling, rate_ * (1.0 + dt_s * (near ? kSlowGrowth : kFastGrowth)));
}

bool RateControl::on_silence(double now_s) {
    // Before the first feedback a client may not have begun to answer.
    if (!settings_.on || heard_s_ < 0.0 || unheard_s_ < 0.0 || now_s - unheard_s_ < kSilence_s ||
        now_s - silenced_s_ < kSilence_s || rate_ <= settings_.floor) {
        return false;
    }
    silenced_s_ = now_s;
    before_silence_ = std::max(before_silence_, rate_);
    cut(0.5 * rate_, now_s);
    return true;
}

}  // namespace zoned::session
