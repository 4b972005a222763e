#include "shared/clock/clock_sync.h"

#include <algorithm>
#include <cmath>

namespace zoned::clock {

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
    const Sample sample{offset, rtt, received_local};
    if (count_ > 0) {
        // Both offsets are true within their uncertainty if no clock was set in between.
        const Sample& believed = best(received_local);
        const double explained =
            uncertainty(believed, received_local) + uncertainty(sample, received_local) + kStep;
        if (std::abs(offset - believed.offset) > explained) {
            count_ = 0;
            ++restarts_;
        }
    }
    // RFC 6298's smoothing of round trips.
    rtt_ = count_ == 0 ? rtt : rtt_ + (rtt - rtt_) / 8.0;
    offset_ = server_time(received_local) - received_local;
    last_local_ = received_local;
    samples_[count_ % kWindow] = sample;
    ++count_;
    target_ = best(received_local).offset;
    if (count_ <= kSettling) {
        offset_ = target_;
    }
}

double ClockSync::server_time(double local) const {
    const double slewed = kSlew * std::max(0.0, local - last_local_);
    return local + offset_ + std::clamp(target_ - offset_, -slewed, slewed);
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
    return uncertainty(best(last_local_), last_local_) + std::abs(target_ - offset_);
}

double ClockSync::uncertainty(const Sample& sample, double local) {
    return 0.5 * sample.rtt + kMaxDrift * (local - sample.local);
}

const ClockSync::Sample& ClockSync::best(double local) const {
    const Sample* least = &samples_[0];
    for (std::size_t i = 1; i < std::min(count_, kWindow); ++i) {
        if (uncertainty(samples_[i], local) < uncertainty(*least, local)) {
            least = &samples_[i];
        }
    }
    return *least;
}

}  // namespace zoned::clock
