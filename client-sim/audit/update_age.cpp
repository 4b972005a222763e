#include "client-sim/audit/update_age.h"

#include "shared/wire/resend_timeout.h"

#include <algorithm>

namespace zoned::audit {

link::UpdateAge age_of(const link::UpdateAge& around,
                       const SentUpdates& sent_updates,
                       bool complete,
                       const link::ArrivalLog& log,
                       Tick tick,
                       double shown_s,
                       const clock::RoundTrip& path,
                       double tick_s) {
    // The last packet received includes all earlier updates; lost packets sent after it are missed.
    Tick missed_since = 0;
    int losses = 0;
    for (const SentUpdates::Packet& packet : sent_updates.packets) {
        const std::optional<double> came_s = log.arrival_s(packet.sequence);
        if (packet.tick > tick) {
            break;
        }
        // A packet that comes after a tick was shown is displayed from the next tick on.
        if (came_s && *came_s < shown_s) {
            missed_since = 0;
            losses = 0;
            continue;
        }
        missed_since = missed_since > 0 ? missed_since : packet.tick;
        losses += log.lost(packet.sequence) ? 1 : 0;
    }
    link::UpdateAge age = around;
    if (losses > 0) {
        // A packet is given up when it is older than that many ticks, so one tick later.
        const Tick given_up = 1 + wire::resend_timeout_ticks(path, tick_s);
        const double gone_by_s = static_cast<double>(tick - missed_since + 1) * tick_s;
        const double once_s =
            std::max(around.age_s, around.delay_s + path.smoothed_s + 2.0 * tick_s);
        const double granted_s =
            around.delay_s + static_cast<double>(1 + losses * given_up) * tick_s;
        age.loss = true;
        age.age_s = std::max(once_s, std::min(gone_by_s, granted_s));
    } else if (complete) {
        age.loss = false;
        age.age_s = around.plain_s;
    }
    if (age.age_s > around.age_s) {
        age.widened = log.notified_bounds(tick, age);
    }
    return age;
}

}  // namespace zoned::audit
