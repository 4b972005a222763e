#include "shared/clock/clock_sync.h"

#include <algorithm>
#include <cmath>

namespace zoned::clock {

namespace {

/// Error of a quartz oscillator, one standard deviation, before anything is known.
constexpr double kUsualDrift = 50e-6;
/// Uncertainty of a good sample's offset beside its queueing: scheduling, stamps, ticks.
constexpr double kLeastNoiseS = 0.3e-3;
/// Samples that contradict each other by more are of other server times, s: the server left ticks
/// out. Stamps are off by much less.
constexpr double kDroppedS = 1e-3;
/// Number of standard deviations within which a drift is believed to be.
constexpr double kDriftSigmas = 2.0;

}  // namespace

void ClockSync::add_sample(double sent_local,
                           double server_receive,
                           double server_send,
                           double received_local) {
    const double rtt = (received_local - sent_local) - (server_send - server_receive);
    // RFC 5905, section 8: theta = ((T2 - T1) + (T3 - T4)) / 2, delta = (T4 - T1) - (T3 - T2).
    const double offset = 0.5 * ((server_receive - sent_local) + (server_send - received_local));
    const bool sense = std::isfinite(rtt) && std::isfinite(offset) && rtt >= 0.0 &&
                       server_send >= server_receive &&
                       (count_ == 0 || received_local >= last_local_);
    if (!sense) {
        return;
    }
    const ClockSample sample{offset, rtt, received_local};
    if (count_ > 0) {
        // Both offsets are true within their uncertainty if no clock was set in between.
        const ClockSample& believed = best(received_local);
        const double unexplained = std::abs(offset - forward(believed, received_local)) -
                                   uncertainty(believed, received_local) -
                                   uncertainty(sample, received_local);
        if (unexplained > kStep) {
            begin_anew();
        } else if (unexplained > kDroppedS) {
            forget_samples();
        }
    }
    round_trip_.add(rtt, received_local);
    offset_ = server_time(received_local) - received_local;
    last_local_ = received_local;
    keep(sample);
    target_ = forward(best(received_local), received_local);
    if (settling_ > 0) {
        --settling_;
        offset_ = target_;
    }
}

void ClockSync::forget_samples() {
    count_ = 0;
    block_count_ = 0;
}

void ClockSync::begin_anew() {
    forget_samples();
    round_trip_ = {};
    drift_ = 0.0;
    drift_doubt_ = kMaxDrift;
    settling_ = kSettling;
    ++restarts_;
}

void ClockSync::keep(const ClockSample& sample) {
    samples_[count_ % kWindow] = sample;
    ++count_;
    if (block_count_ == 0 || sample.local - block_s_ >= kBlockS) {
        block_s_ = sample.local;
        if (block_count_ > 0) {
            estimate_drift();  // by whole blocks: their best samples are final
        }
        blocks_[block_count_++ % kBlocks] = sample;
        return;
    }
    ClockSample& least = blocks_[(block_count_ - 1) % kBlocks];
    if (sample.rtt < least.rtt) {
        least = sample;
    }
}

/// Weighted least squares of offsets over time, with kUsualDrift as prior of the slope. The weight
/// of a sample is that of half its round trip above the least one: where it was delayed, in either
/// direction.
void ClockSync::estimate_drift() {
    const std::size_t n = std::min(block_count_, kBlocks);
    double least = blocks_[0].rtt;
    for (std::size_t i = 1; i < n; ++i) {
        least = std::min(least, blocks_[i].rtt);
    }
    // Relative to one of them: offsets are large numbers that differ by little.
    const ClockSample& origin = blocks_[0];
    double sum = 0.0;
    double time = 0.0;
    double offset = 0.0;
    double time_time = 0.0;
    double time_offset = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        const double noise = kLeastNoiseS + 0.5 * (blocks_[i].rtt - least);
        const double weight = 1.0 / (noise * noise);
        const double t = blocks_[i].local - origin.local;
        const double o = blocks_[i].offset - origin.offset;
        sum += weight;
        time += weight * t;
        offset += weight * o;
        time_time += weight * t * t;
        time_offset += weight * t * o;
    }
    const double spread = time_time - time * time / sum;
    const double information = spread + 1.0 / (kUsualDrift * kUsualDrift);
    drift_ = std::clamp((time_offset - time * offset / sum) / information, -kMaxDrift, kMaxDrift);
    drift_doubt_ = std::min(kMaxDrift, kDriftSigmas / std::sqrt(information));
}

double ClockSync::server_time(double local) const {
    const double passed = std::max(0.0, local - last_local_);
    const double slewed = kSlew * passed;
    // Drift is part of what is slewed: time never runs more unevenly than kSlew.
    const double change = target_ + drift_ * passed - offset_;
    return local + offset_ + std::clamp(change, -slewed, slewed);
}

double ClockSync::min_rtt_s() const {
    double least = count_ == 0 ? 0.0 : samples_[0].rtt;
    for (std::size_t i = 0; i < std::min(count_, kWindow); ++i) {
        least = std::min(least, samples_[i].rtt);
    }
    return least;
}

double ClockSync::error_bound_s() const {
    if (count_ == 0) {
        return 0.0;
    }
    double least = uncertainty(samples_[0], last_local_) +
                   std::abs(offset_ - forward(samples_[0], last_local_));
    const auto consider = [&](const ClockSample& sample) {
        least = std::min(
            least,
            uncertainty(sample, last_local_) + std::abs(offset_ - forward(sample, last_local_)));
    };
    std::for_each_n(samples_.begin(), std::min(count_, kWindow), consider);
    std::for_each_n(blocks_.begin(), std::min(block_count_, kBlocks), consider);
    return least;
}

double ClockSync::doubt(const ClockSample& sample, double local) const {
    return 0.5 * sample.rtt + drift_doubt_ * (local - sample.local);
}

double ClockSync::uncertainty(const ClockSample& sample, double local) const {
    return 0.5 * sample.rtt + (kMaxDrift + std::abs(drift_)) * (local - sample.local);
}

double ClockSync::forward(const ClockSample& sample, double local) const {
    return sample.offset + drift_ * (local - sample.local);
}

const ClockSync::ClockSample& ClockSync::best(double local) const {
    const ClockSample* least = &samples_[0];
    const auto consider = [&](const ClockSample& sample) {
        if (doubt(sample, local) < doubt(*least, local)) {
            least = &sample;
        }
    };
    std::for_each_n(samples_.begin(), std::min(count_, kWindow), consider);
    std::for_each_n(blocks_.begin(), std::min(block_count_, kBlocks), consider);
    return *least;
}

}  // namespace zoned::clock
