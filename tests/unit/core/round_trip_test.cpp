#include "shared/clock/round_trip.h"

#include <gtest/gtest.h>

namespace zoned::clock {
namespace {

TEST(RoundTripEstimator, BeginsWithTheFirstSampleAndHalfOfItAsVariation) {
    RoundTripEstimator estimator;
    EXPECT_FALSE(estimator.known());
    estimator.add(0.080, 1.0);
    EXPECT_DOUBLE_EQ(estimator.value().smoothed_s, 0.080);
    EXPECT_DOUBLE_EQ(estimator.value().variation_s, 0.040);
}

/// RFC 9002, section 5.3: rttvar = 3/4 rttvar + 1/4 |smoothed - sample|, with the smoothed round
/// trip before the sample.
TEST(RoundTripEstimator, SmoothsAsTheRfcDoes) {
    RoundTripEstimator estimator;
    estimator.add(0.080, 1.0);
    estimator.add(0.120, 1.1);
    EXPECT_NEAR(estimator.value().variation_s, 0.75 * 0.040 + 0.25 * 0.040, 1e-12);
    EXPECT_NEAR(estimator.value().smoothed_s, 0.875 * 0.080 + 0.125 * 0.120, 1e-12);
    for (int i = 0; i < 100; ++i) {
        estimator.add(0.1, 1.2 + 0.1 * i);
    }
    EXPECT_NEAR(estimator.value().smoothed_s, 0.1, 1e-6);
    EXPECT_LT(estimator.value().variation_s, 1e-6);
}

TEST(RoundTripEstimator, RemembersTheLongestForTwoToFourSeconds) {
    RoundTripEstimator estimator;
    estimator.add(0.4, 10.0);
    double forgotten_s = 0.0;
    for (int i = 1; i < 60 && forgotten_s == 0.0; ++i) {
        const double now_s = 10.0 + 0.1 * i;
        estimator.add(0.05, now_s);
        forgotten_s = estimator.value().longest_s < 0.4 ? now_s : 0.0;
    }
    EXPECT_GE(forgotten_s, 12.0);
    EXPECT_LE(forgotten_s, 14.1);
    EXPECT_DOUBLE_EQ(estimator.value().longest_s, 0.05);
}

}  // namespace
}  // namespace zoned::clock
