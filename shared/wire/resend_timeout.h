// resend_timeout: how long the server waits for a packet's acknowledgement before it sends the
// updates again.
#pragma once

#include "shared/core/ids.h"

#include <cmath>

namespace zoned::wire {

/// A packet older than this, in ticks, is given up, and sooner where later packets were
/// acknowledged. The time is a round trip and a tick, as the promised bound allows for a resend.
/// `rtt_s` >= 0, `tick_s` > 0.
inline Tick resend_timeout_ticks(double rtt_s, double tick_s) {
    return 1 + static_cast<Tick>(std::ceil(rtt_s / tick_s));
}

}  // namespace zoned::wire
