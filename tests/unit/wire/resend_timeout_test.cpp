#include "shared/wire/resend_timeout.h"

#include <gtest/gtest.h>

namespace zoned::wire {
namespace {

/// The promised bound allows a resend a round trip and a tick. Actions happen at ticks, which makes
/// both a tick longer at most.
TEST(GiveUp, WaitsForARoundTripAndNoLongerThanThePromisedBoundAllowsAResend) {
    for (const double tick_s : {1.0 / 60.0, 1.0 / 30.0, 0.05}) {
        for (double rtt_s = 0.0; rtt_s < 2.0; rtt_s += 0.0037) {
            const double waited_s =
                static_cast<double>(resend_timeout_ticks(rtt_s, tick_s)) * tick_s;
            EXPECT_GE(waited_s, rtt_s);
            EXPECT_LT(waited_s, rtt_s + 2.0 * tick_s + 1e-9);
        }
    }
}

}  // namespace
}  // namespace zoned::wire
