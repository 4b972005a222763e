#include "client-sim/link/conditioner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::link {

namespace {

/// Seconds until the outage that covers `now_s` ends; 0 outside of outages.
double outage_left_s(const ConditionerSettings& settings, double now_s) {
    if (settings.outage_every_s <= 0.0 || now_s < settings.outage_every_s) {
        return 0.0;
    }
    const double into = std::fmod(now_s, settings.outage_every_s);
    return into < settings.outage_length_s ? settings.outage_length_s - into : 0.0;
}

}  // namespace

Conditioner::Conditioner(const ConditionerSettings& settings,
                         Mode mode,
                         std::uint64_t stream,
                         Direction direction)
    : settings_(settings),
      mode_(mode),
      rng_(settings.seed, stream),
      bottleneck_(mode == Mode::kFrames         ? 0.0
                  : direction == Direction::kUp ? settings.bottleneck_up_bytes_per_s
                                                : settings.bottleneck_down_bytes_per_s,
                  settings.bottleneck_queue_s) {
}

bool Conditioner::later(const DelayedMessage& a, const DelayedMessage& b) {
    return a.due_s != b.due_s ? a.due_s > b.due_s : a.order > b.order;
}

bool Conditioner::chance(double probability) {
    return probability > 0.0 && rng_.unit() < static_cast<float>(probability);
}

double Conditioner::draw_delay() {
    const double jitter = settings_.jitter_s * (2.0 * static_cast<double>(rng_.unit()) - 1.0);
    return std::max(0.0, settings_.delay_s + (settings_.jitter_s > 0.0 ? jitter : 0.0));
}

void Conditioner::insert(double due_s, Bytes message) {
    heap_.push_back({due_s, order_++, std::move(message)});
    std::push_heap(heap_.begin(), heap_.end(), later);
}

void Conditioner::push(double now_s, Bytes message) {
    if (healed_) {
        // A stream keeps its order also when it heals.
        last_due_s_ = std::max(last_due_s_, now_s);
        insert(mode_ == Mode::kFrames ? last_due_s_ : now_s, std::move(message));
        return;
    }
    const double outage = outage_left_s(settings_, now_s);
    if (mode_ == Mode::kFrames) {
        // A stream keeps its order: nothing overtakes the frame before it.
        last_due_s_ = std::max(last_due_s_, now_s + outage + draw_delay());
        insert(last_due_s_, std::move(message));
        return;
    }
    // Every datagram draws the same number of decisions, so that one setting does not shift the
    // random numbers of another.
    const bool lost = chance(settings_.loss);
    const bool doubled = chance(settings_.duplicate);
    const bool held = chance(settings_.reorder);
    PlannedDelivery planned;
    planned.lost = lost;
    planned.delay_s = draw_delay();
    if (held && !lost && outage <= 0.0) {
        ++held_back_;
        planned.delay_s += settings_.reorder_hold_s * (1.0 + static_cast<double>(rng_.unit()));
    }
    if (doubled && !lost && outage <= 0.0) {
        planned.copy_delay_s = draw_delay();
    }
    if (outage > 0.0) {
        ++lost_;
        return;
    }
    const double bytes = static_cast<double>(message.size()) + settings_.header_bytes;
    planned.message = std::move(message);
    if (!bottleneck_.limits()) {
        travel(now_s, std::move(planned));
        return;
    }
    serve(now_s);
    if (bottleneck_.push(now_s, entered_, bytes)) {
        queued_.emplace(entered_++, std::move(planned));
    }
}

/// The network path behind the bottleneck.
void Conditioner::travel(double from_s, PlannedDelivery planned) {
    if (planned.lost) {
        ++lost_;
        return;
    }
    if (planned.copy_delay_s >= 0.0) {
        ++doubled_;
        insert(from_s + planned.copy_delay_s, planned.message);
    }
    insert(from_s + planned.delay_s, std::move(planned.message));
}

void Conditioner::serve(double now_s) {
    Bottleneck::Departure departure;
    while (bottleneck_.pop(now_s, departure)) {
        auto node = queued_.extract(departure.number);
        travel(departure.at_s, std::move(node.mapped()));
    }
}

void Conditioner::set_bottleneck(double now_s, double bytes_per_s) {
    serve(now_s);
    bottleneck_.set_rate(now_s, bytes_per_s);
}

bool Conditioner::pop_due(double now_s, Bytes& out) {
    serve(now_s);
    if (heap_.empty() || heap_.front().due_s > now_s) {
        return false;
    }
    std::pop_heap(heap_.begin(), heap_.end(), later);
    out = std::move(heap_.back().message);
    heap_.pop_back();
    return true;
}

double Conditioner::next_due_s() const {
    // A datagram that leaves the bottleneck may still be delayed: then nothing is due yet at that
    // time.
    const double due_s =
        heap_.empty() ? std::numeric_limits<double>::infinity() : heap_.front().due_s;
    return std::min(due_s, bottleneck_.next_s());
}

}  // namespace zoned::link
