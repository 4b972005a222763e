#include "server/compute/crossover.h"

#include <gtest/gtest.h>

namespace zoned::compute {
namespace {

const SideCost kCpu{0.0, 0.001, 0.0};
const SideCost kFastDevice{30.0, 0.0002, 0.0002};

TEST(Crossover, ChoosesTheFasterSideByWorkSize) {
    const Crossover crossover(kCpu, kFastDevice);
    EXPECT_EQ(crossover.choose(1000, false, false), Side::kCpu);
    EXPECT_EQ(crossover.choose(1'000'000, false, false), Side::kDevice);
    // 30 / (0.95 x 0.001 - 0.0004) = 54,545
    EXPECT_EQ(crossover.threshold(), 54'546U);
    EXPECT_EQ(crossover.choose(crossover.threshold() - 1, false, false), Side::kCpu);
    EXPECT_EQ(crossover.choose(crossover.threshold() + 1, false, false), Side::kDevice);
}

TEST(Crossover, KeepsHashedWorkOffADeviceThatIsNotExact) {
    const Crossover crossover(kCpu, kFastDevice);
    EXPECT_EQ(crossover.choose(1'000'000, true, false), Side::kCpu);
    EXPECT_EQ(crossover.choose(1'000'000, true, true), Side::kDevice);
}

TEST(Crossover, IsTheCpuUntilItIsMeasured) {
    EXPECT_EQ(Crossover().choose(1'000'000'000, false, true), Side::kCpu);
    EXPECT_EQ(Crossover().threshold(), SIZE_MAX);
}

TEST(Crossover, CountsCopies) {
    SideCost copying = kFastDevice;
    copying.copy_us = 0.002;
    EXPECT_EQ(Crossover(kCpu, copying).choose(1'000'000, false, true), Side::kCpu);
    EXPECT_EQ(Crossover(kCpu, copying).threshold(), SIZE_MAX);
}

TEST(Crossover, FindsTheLineThroughTwoMeasurements) {
    const SideCost cost = cost_through(1000, 31.0, 101'000, 131.0);
    EXPECT_DOUBLE_EQ(cost.item_us, 0.001);
    EXPECT_DOUBLE_EQ(cost.launch_us, 30.0);
    EXPECT_EQ(cost_through(1000, 50.0, 2000, 40.0).item_us, 0.0);  // noise
}

}  // namespace
}  // namespace zoned::compute
