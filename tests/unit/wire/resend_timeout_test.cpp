#include "shared/wire/resend_timeout.h"

#include <gtest/gtest.h>

namespace zoned::wire {
namespace {

/// The promised bound allows a resend a round trip and a tick, and four times what the round trip
/// varies by. Actions happen at ticks, which makes both a tick longer at most.
TEST(GiveUp, WaitsForARoundTripAndNoLongerThanThePromisedBoundAllowsAResend) {
    for (const double tick_s : {1.0 / 60.0, 1.0 / 30.0, 0.05}) {
        for (double rtt_s = 0.0; rtt_s < 2.0; rtt_s += 0.0037) {
            for (const double variation_s : {0.0, 0.003, 0.05}) {
                const double waited_s =
                    static_cast<double>(resend_timeout_ticks({rtt_s, variation_s}, tick_s)) *
                    tick_s;
                EXPECT_GE(waited_s, rtt_s + 4.0 * variation_s);
                EXPECT_LT(waited_s, rtt_s + 4.0 * variation_s + 2.0 * tick_s + 1e-9);
            }
        }
    }
}

TEST(GiveUp, WaitsForTheLongestRoundTripOfLate) {
    clock::RoundTrip path(0.05);
    path.longest_s = 0.4;
    EXPECT_EQ(resend_timeout_ticks(path, 0.1), 5);
}

}  // namespace
}  // namespace zoned::wire
