#include "server/app/world/overload_steps.h"

#include <gtest/gtest.h>

namespace zoned::app {
namespace {

TEST(OverloadSteps, BeginAndEndOnceAndNotInBetween) {
    OverloadSteps steps;
    int changes = 0;
    const auto run = [&](std::uint64_t late, int ticks) {
        for (int i = 0; i < ticks; ++i) {
            changes += steps.tick({100, late, 0}) ? 1 : 0;
        }
    };
    run(5, 300);
    EXPECT_FALSE(steps.on(OverloadStep::kCopies)) << "a twentieth is not enough";
    run(50, 300);
    EXPECT_TRUE(steps.on(OverloadStep::kCopies));
    run(5, 300);
    EXPECT_TRUE(steps.on(OverloadStep::kCopies)) << "nor is it the end";
    run(0, 300);
    EXPECT_FALSE(steps.on(OverloadStep::kCopies));
    EXPECT_EQ(changes, 2);
    EXPECT_FALSE(steps.on(OverloadStep::kBounds));
}

TEST(OverloadSteps, TakeNoNoticeOfASingleTick) {
    OverloadSteps steps;
    EXPECT_FALSE(steps.tick({10, 10, 10}));
    EXPECT_FALSE(steps.tick({0, 0, 0}));
}

}  // namespace
}  // namespace zoned::app
