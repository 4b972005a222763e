#include "server/ai/learning/adaptation.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace zoned::ai::learning {
namespace {

/// Gap after 120 s of a chase, where the chaser's own speed is `ratio` of the target's.
float gap_after(const RubberBand* band, float ratio) {
    constexpr float kDt = 1.0F / 30.0F;
    float gap = 8.0F;
    float factor = 1.0F;
    for (int tick = 0; tick < 120 * 30; ++tick) {
        factor = band != nullptr ? banded(*band, factor, gap, kDt) : 1.0F;
        gap += (5.0F - 5.0F * ratio * factor) * kDt;
    }
    return gap;
}

TEST(RubberBand, KeepsAChaseCloseThatWouldDriftApart) {
    const RubberBand band;
    // In balance the factor is 1 / ratio: gap = wanted (1 + (1 / ratio - 1) / gain).
    for (const float ratio : {0.9F, 0.95F, 1.0F, 1.05F, 1.1F}) {
        const float balance = 8.0F * (1.0F + (1.0F / ratio - 1.0F) / 0.5F);
        EXPECT_NEAR(gap_after(&band, ratio), balance, 0.1F) << ratio;
    }
    EXPECT_GT(gap_after(nullptr, 0.9F), 50.0F);
    // Beyond the cap even the band gives up: a much slower chaser is left behind.
    EXPECT_GT(gap_after(&band, 0.5F), 100.0F);
}

TEST(RubberBand, NeverLeavesItsCapNorJumps) {
    const RubberBand band;
    core::Rng rng(4);
    const float inf = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    float factor = 1.0F;
    for (int i = 0; i < 100000; ++i) {
        const float odd[] = {rng.range(-1e6F, 1e6F), rng.range(0.0F, 30.0F), inf, -inf, nan, 1e38F};
        const float before = factor;
        factor = banded(band, factor, odd[rng.below(6)], 0.05F);
        EXPECT_GE(factor, band.least);
        EXPECT_LE(factor, band.most);
        EXPECT_LE(std::abs(factor - before), band.rate_per_s * 0.05F + 1e-6F);
    }
    for (const float bad : {nan, inf, 50.0F, -50.0F}) {
        const float from_bad = banded(band, bad, 8.0F, 0.05F);
        EXPECT_GE(from_bad, band.least);
        EXPECT_LE(from_bad, band.most);
    }
}

TEST(Staircase, SettlesWherePlayersSucceedAsOftenAsWanted) {
    // A player who succeeds with probability 1 - level: wanted 0.6 is a level of 0.4.
    core::Rng rng(8);
    const Staircase staircase{0.6F, 0.02F, 0.0F, 1.0F};
    float level = 1.0F;
    double mean = 0.0;
    constexpr int kSettle = 500;
    constexpr int kCount = 20000;
    for (int i = 0; i < kSettle + kCount; ++i) {
        level = stepped(staircase, level, rng.unit() < 1.0F - level);
        mean += i >= kSettle ? static_cast<double>(level) / kCount : 0.0;
    }
    // A step pulls back by step * distance: the level wanders with variance step * p (1 - p) / 2
    // over 1 / step outcomes. So its mean over n has a deviation of sqrt(p (1 - p) / n) = 0.0035.
    EXPECT_NEAR(mean, 0.4, 5.0 * 0.0035);
}

TEST(Staircase, NeverLeavesItsCap) {
    const Staircase staircase{0.5F, 0.3F, 0.2F, 0.7F};
    core::Rng rng(9);
    float level = std::numeric_limits<float>::quiet_NaN();
    for (int i = 0; i < 1000; ++i) {
        level = stepped(staircase, level, (rng.next() & 1U) != 0);
        EXPECT_GE(level, 0.2F);
        EXPECT_LE(level, 0.7F);
    }
}

}  // namespace
}  // namespace zoned::ai::learning
