#include "client-sim/link/bottleneck.h"

#include <algorithm>

namespace zoned::link {

Bottleneck::Bottleneck(double bytes_per_s, double queue_s)
    : bytes_per_s_(bytes_per_s),
      queue_s_(queue_s) {
}

double Bottleneck::backlog_s(double now_s) const {
    // The queue is served without a pause from clock_s_ on.
    return std::max(0.0, clock_s_ + queued_bytes_ / bytes_per_s_ - now_s);
}

bool Bottleneck::push(double now_s, std::uint64_t number, double bytes) {
    if (queue_.empty()) {
        clock_s_ = std::max(clock_s_, now_s);
        queued_bytes_ = 0.0;  // rounding must not add up
    }
    if (backlog_s(now_s) > queue_s_) {
        ++meter_.dropped;
        return false;
    }
    queue_.push_back({number, now_s, bytes, bytes, false});
    queued_bytes_ += bytes;
    return true;
}

bool Bottleneck::pop(double now_s, Departure& out) {
    if (queue_.empty()) {
        return false;
    }
    QueuedSize& head = queue_.front();
    if (!head.begun) {
        head.begun = true;
        clock_s_ = std::max(clock_s_, head.entered_s);
        meter_.wait_s.add(clock_s_ - head.entered_s);
    }
    const double done_s = clock_s_ + head.left / bytes_per_s_;
    if (done_s > now_s) {
        return false;
    }
    clock_s_ = done_s;
    queued_bytes_ -= head.left;
    ++meter_.carried;
    meter_.carried_bytes += head.bytes;
    out = {head.number, done_s};
    queue_.pop_front();
    return true;
}

double Bottleneck::next_s() const {
    if (queue_.empty()) {
        return std::numeric_limits<double>::infinity();
    }
    const QueuedSize& head = queue_.front();
    return std::max(clock_s_, head.entered_s) + head.left / bytes_per_s_;
}

void Bottleneck::set_rate(double now_s, double bytes_per_s) {
    if (!queue_.empty() && now_s > clock_s_) {
        QueuedSize& head = queue_.front();
        const double sent = std::min(head.left, (now_s - clock_s_) * bytes_per_s_);
        head.left -= sent;
        queued_bytes_ -= sent;
        if (!head.begun) {
            head.begun = true;
            meter_.wait_s.add(clock_s_ - head.entered_s);
        }
    }
    clock_s_ = std::max(clock_s_, now_s);
    meter_.capacity_bytes += std::max(0.0, now_s - metered_s_) * bytes_per_s_;
    metered_s_ = std::max(metered_s_, now_s);
    bytes_per_s_ = bytes_per_s;
}

BottleneckMeter Bottleneck::meter(double now_s) const {
    BottleneckMeter result = meter_;
    result.capacity_bytes += std::max(0.0, now_s - metered_s_) * bytes_per_s_;
    return result;
}

void Bottleneck::restart_meter(double now_s) {
    meter_ = {};
    metered_s_ = now_s;
}

}  // namespace zoned::link
