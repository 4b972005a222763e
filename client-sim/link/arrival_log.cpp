#include "client-sim/link/arrival_log.h"

#include "shared/wire/resend_timeout.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::link {

void ArrivalLog::on_packet(std::uint64_t sequence,
                           Tick tick,
                           double arrival_server_s,
                           const wire::Widened& widened) {
    ++received_;
    arrivals_[arrival_count_++ % kArrivals] = {tick, arrival_server_s, widened};
    places_[sequence % kArrivals] = {sequence, arrival_server_s};
    if (sequence <= newest_) {
        note_late(sequence, arrival_server_s);
        return;
    }
    if (newest_ != 0 && sequence > newest_ + 1) {
        gaps_[gap_count_++ % kGaps] = {
            newest_ + 1, sequence - 1, newest_tick_, tick, arrival_server_s, 0};
        missing_ += sequence - newest_ - 1;
    }
    newest_ = sequence;
    newest_tick_ = std::max(newest_tick_, tick);
}

void ArrivalLog::set_back(double server_s) {
    arrival_count_ = 0;
    gap_count_ = 0;
    for (SequenceArrival& place : places_) {
        place.arrival_s = std::min(place.arrival_s, server_s);
    }
}

std::optional<double> ArrivalLog::arrival_s(std::uint64_t sequence) const {
    const SequenceArrival& place = places_[sequence % kArrivals];
    return place.sequence == sequence ? std::optional<double>(place.arrival_s) : std::nullopt;
}

void ArrivalLog::note_late(std::uint64_t sequence, double arrival_server_s) {
    const std::size_t kept = std::min(gap_count_, kGaps);
    for (std::size_t i = 0; i < kept; ++i) {
        SequenceGap& gap = gaps_[i];
        if (sequence >= gap.first && sequence <= gap.last && gap.filled <= gap.last - gap.first) {
            ++gap.filled;
            --missing_;
            // A late packet delivered its updates when it came.
            gap.closed_s = std::max(gap.closed_s, arrival_server_s);
            return;
        }
    }
}

UpdateAge ArrivalLog::at(Tick tick, const clock::RoundTrip& path, double window_s) const {
    UpdateAge age;
    const double at_s = static_cast<double>(tick) * tick_s_;
    const std::size_t arrivals = std::min(arrival_count_, kArrivals);
    double stalled_s = 0.0;
    for (std::size_t i = 0; i < arrivals; ++i) {
        const Arrival& a = arrivals_[i];
        const double sent_s = static_cast<double>(a.tick) * tick_s_;
        if (sent_s <= at_s && a.arrival_s > at_s) {
            stalled_s = std::max(stalled_s, at_s - sent_s + tick_s_);
            age.measured = true;
        }
        if (a.arrival_s >= at_s - window_s && a.arrival_s <= at_s + window_s) {
            age.delay_s = std::max(age.delay_s, a.arrival_s - sent_s);
            age.measured = true;
        }
    }
    age.age_s = age.delay_s + tick_s_;
    const double resend_s = path.smoothed_s + tick_s_;
    const std::size_t holes = std::min(gap_count_, kGaps);
    double outage_s = 0.0;
    for (std::size_t i = 0; i < holes; ++i) {
        const SequenceGap& gap = gaps_[i];
        const bool whole = gap.filled > gap.last - gap.first;
        // Lost updates matter at T from the tick after the last packet before the gap. They matter
        // until the server has given up the gap's last packet and its resend has come: a packet of
        // the tick after that.
        const double from_s = static_cast<double>(gap.tick_before) * tick_s_;
        const Tick sent_again = gap.tick_after + wire::resend_timeout_ticks(path, tick_s_);
        const double until_s =
            whole ? gap.closed_s + tick_s_
                  : std::max(gap.closed_s + resend_s,
                             static_cast<double>(sent_again) * tick_s_ + age.delay_s) +
                        tick_s_;
        if (at_s <= from_s || at_s > until_s) {
            continue;
        }
        age.loss = age.loss || !whole;
        if (gap.tick_after - gap.tick_before > kOutageTicks) {
            outage_s = std::max(outage_s, at_s - from_s);
        }
    }
    if (age.loss) {
        age.age_s += resend_s;
    }
    const double silence_s = std::max(outage_s, stalled_s);
    age.age_s = std::max(age.age_s, silence_s);
    age.plain_s = std::max(age.delay_s + tick_s_, silence_s);
    age.widened = notified_bounds(tick, age);
    return age;
}

/// The states shown at a tick were sent up to D before it, under the bounds of that time. These are
/// the bounds of the packets since, and of the last packet before, which hold until the next. Where
/// packets were lost, the next one repeats their bounds.
wire::Widened ArrivalLog::notified_bounds(Tick tick, const UpdateAge& age) const {
    const auto ticks = static_cast<Tick>(std::ceil(age.age_s / tick_s_)) + 1;
    const Tick until = age.loss ? tick + ticks : tick;
    Tick from = std::numeric_limits<Tick>::min();
    for (std::size_t i = 0; i < std::min(arrival_count_, kArrivals); ++i) {
        from = arrivals_[i].tick <= tick - ticks ? std::max(from, arrivals_[i].tick) : from;
    }
    wire::Widened widest;
    for (std::size_t i = 0; i < std::min(arrival_count_, kArrivals); ++i) {
        const Arrival& a = arrivals_[i];
        if (a.tick >= from && a.tick <= until) {
            widest.step = std::max(widest.step, a.widened.step);
            widest.incomplete = widest.incomplete || a.widened.incomplete;
        }
    }
    return widest;
}

}  // namespace zoned::link
