#include "server/replication/delivery/ack_delay.h"

#include <algorithm>
#include <cmath>

namespace zoned::replication {

namespace {

constexpr double kPeriod_s = 1.0;
constexpr Tick kSoonestPeriods = 30;

}  // namespace

void AckDelay::on_acked(const Acked& acked) {
    fresh_.push_back(acked);
}

void AckDelay::begin_tick(Tick now, float tick_s, Tick patience, Tick round_trip) {
    patience_ = patience;
    round_trip_ = round_trip;
    const auto period = static_cast<Tick>(std::ceil(kPeriod_s / static_cast<double>(tick_s)));
    if (now - period_tick_ >= period) {
        delay_ = {0, now - period_tick_ < 2 * period ? delay_.now : 0};
        reordered_ = {0, now - period_tick_ < 2 * period ? reordered_.now : 0};
        period_tick_ = now;
    }
    if (now - soonest_tick_ >= kSoonestPeriods * period) {
        soonest_before_ = soonest_now_;
        soonest_now_ = kNever;
        soonest_tick_ = now;
    }
    if (now - tolerance_tick_ >= 2 * period) {
        tolerance_ = kLeastTolerance;
    }
    for (const Acked& acked : fresh_) {
        if (!acked.outage) {
            (acked.overtaken_by > 0 ? reordered_ : delay_).add(now - acked.sent_tick);
            soonest_now_ = std::min(soonest_now_, now - acked.sent_tick);
        }
        if (acked.given_up && acked.overtaken_by >= tolerance_) {
            tolerance_ = std::min(kMostTolerance, acked.overtaken_by + 1);
            tolerance_tick_ = now;
        }
    }
    if (!fresh_.empty()) {
        doublings_ = 0;
        probe_tick_ = -1;
    } else if (probe_tick_ >= 0 && now - probe_tick_ > overdue_after()) {
        doublings_ = std::min(doublings_ + 1, kMostDoublings);
        probe_tick_ = -1;
    }
    fresh_.clear();
}

/// Acknowledgements of a tick come before it looks: an age that was seen is not overdue yet.
Tick AckDelay::reordered_after() const {
    return std::max(round_trip_, reordered_.value() - 1);
}

Tick AckDelay::overdue_after() const {
    return std::max(patience_, delay_.value() - 1) << doublings_;
}

bool AckDelay::probe(Tick now, Tick age) {
    if (age <= overdue_after()) {
        return false;
    }
    // Packets that become overdue before an answer to the first probe can be there go with it: the
    // same burst may have lost them, and the promised bound allows for one resend.
    probe_tick_ = probe_tick_ < 0 ? now : probe_tick_;
    return true;
}

void AckDelay::hash(core::StateHash& hash) const {
    hash.add(delay_.value());
    hash.add(reordered_.value());
    hash.add(tolerance_);
    hash.add(doublings_);
    hash.add(late());
}

}  // namespace zoned::replication
