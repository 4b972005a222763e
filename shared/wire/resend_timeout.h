// GiveUp: how long the server waits for word of a packet before it sends its news again.
#pragma once

#include "shared/core/ids.h"

#include <cmath>

namespace zoned::wire {

/// A packet is given up that is more ticks old than this, or sooner where later ones were
/// acknowledged: a round trip and a tick, which is what the promised bound allows a resend.
/// `rtt_s` >= 0, `tick_s` > 0.
inline Tick resend_timeout_ticks(double rtt_s, double tick_s) {
    return 1 + static_cast<Tick>(std::ceil(rtt_s / tick_s));
}

}  // namespace zoned::wire
