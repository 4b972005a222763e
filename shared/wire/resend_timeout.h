// resend_timeout: how long the server waits for a packet's acknowledgement before it sends the
// updates again.
#pragma once

#include "shared/clock/round_trip.h"
#include "shared/core/ids.h"

#include <algorithm>
#include <cmath>

namespace zoned::wire {

/// A packet older than this, in ticks, is lost where a later one was acknowledged and reordering
/// does not explain it (RFC 9002, section 6.1.2): a round trip, and the tick for which a client may
/// keep an acknowledgement back. `rtt_s` >= 0, `tick_s` > 0.
inline Tick round_trip_ticks(double rtt_s, double tick_s) {
    return 1 + static_cast<Tick>(std::ceil(rtt_s / tick_s));
}

/// A packet older than this, in ticks, is given up, and sooner where later packets were
/// acknowledged. The time is a round trip, four times its variation (RFC 9002, section 6.2.1:
/// smoothed_rtt + 4 * rttvar + max_ack_delay), and the tick for which a client may keep an
/// acknowledgement back. It is no shorter than the longest round trip of late: what is late is not
/// lost. The audit grants a resend the same time by the client's own round trips. `tick_s` > 0.
inline Tick resend_timeout_ticks(const clock::RoundTrip& path, double tick_s) {
    const double usual_s = path.smoothed_s + 4.0 * path.variation_s;
    return 1 + static_cast<Tick>(std::ceil(std::max(usual_s, path.longest_s) / tick_s));
}

}  // namespace zoned::wire
