#include "server/app/runtime/tick_schedule.h"

#include <gtest/gtest.h>

namespace zoned::app {
namespace {

// All times are multiples of 1/32 s, so that arithmetic is exact and the tests need no tolerance.
constexpr double kRate = 32.0;
constexpr double kDt = 1.0 / kRate;

TEST(TickSchedule, RunsOneTickPerPeriodAndKeepsPhase) {
    TickSchedule schedule(kRate, 3, 100.0);
    for (int i = 1; i <= 1000; ++i) {
        // Each wake-up is late by up to half a period; lateness must not add up.
        const double now = 100.0 + (i + 0.5 * (i % 2)) * kDt;
        ASSERT_TRUE(schedule.due(now));
        schedule.ran();
        EXPECT_FALSE(schedule.due(now));
        EXPECT_DOUBLE_EQ(schedule.next_due(), 100.0 + (i + 1) * kDt);
    }
    EXPECT_EQ(schedule.dropped(), 0u);
}

TEST(TickSchedule, CatchesUpAFewTicksWithoutDroppingAny) {
    TickSchedule schedule(kRate, 3, 0.0);
    const double now = 4.0 * kDt;  // ticks 1..4 are due: one on time and three behind
    int ran = 0;
    while (schedule.due(now)) {
        schedule.ran();
        ++ran;
    }
    EXPECT_EQ(ran, 4);
    EXPECT_EQ(schedule.dropped(), 0u);
    EXPECT_DOUBLE_EQ(schedule.server_time(now), now);
}

TEST(TickSchedule, DropsWhatALongStallLeavesAndNeverSpirals) {
    TickSchedule schedule(kRate, 3, 0.0);
    const double now = 320.0 * kDt;  // a stall of ten seconds
    int ran = 0;
    while (schedule.due(now)) {
        schedule.ran();
        ++ran;
    }
    EXPECT_EQ(ran, 4);
    EXPECT_EQ(schedule.dropped(), 316u);
    // Server time stood still for the dropped ticks: tick t still lies at t * dt.
    EXPECT_DOUBLE_EQ(schedule.server_time(now), 4.0 * kDt);
    EXPECT_DOUBLE_EQ(schedule.next_due(), now + kDt);
}

TEST(TickSchedule, StaysBoundedWhenEveryTickTakesTooLong) {
    TickSchedule schedule(kRate, 3, 0.0);
    double now = 0.0;
    for (int i = 0; i < 1000; ++i) {
        now += 2.0 * kDt;  // each tick takes two periods
        ASSERT_TRUE(schedule.due(now));
        schedule.ran();
        // Never farther behind than the ticks that may be caught up, plus the present tick.
        ASSERT_LE(schedule.server_time(now) - static_cast<double>(schedule.done()) * kDt,
                  4.0 * kDt);
    }
    EXPECT_GT(schedule.dropped(), 900u);
}

}  // namespace
}  // namespace zoned::app
