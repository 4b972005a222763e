#include "server/net/gather_schedule.h"

#include <gtest/gtest.h>

#include <vector>

namespace zoned::net {
namespace {

constexpr double kGatherTick_s = 0.05;
constexpr std::size_t kGatherBuffer = 8U << 20U;  // 512 pages are a quarter of it

/// The moments of the readings before a tick that is due at the end of the period. Each begins
/// `late_s` after its time and takes `took_s`.
std::vector<double> readings(GatherSchedule& schedule, double late_s, double took_s) {
    std::vector<double> out;
    double now = 0.0;
    for (double until = schedule.hold_until(now, kGatherTick_s); until > now;
         until = schedule.hold_until(now, kGatherTick_s)) {
        now = until + late_s;
        out.push_back(now);
        now += took_s;
        schedule.note_reading(until, now);
    }
    return out;
}

/// So many datagrams came in the period before.
GatherSchedule after_a_period_of(std::uint64_t datagrams) {
    GatherSchedule schedule(kGatherBuffer);
    schedule.begin_tick(0, -kGatherTick_s);
    schedule.begin_tick(datagrams, 0.0);
    return schedule;
}

TEST(GatherSchedule, LetsNothingWaitWhereReadingTogetherSavesNoWakeUps) {
    EXPECT_EQ(GatherSchedule(kGatherBuffer).hold_until(0.0, kGatherTick_s), 0.0);
    GatherSchedule few = after_a_period_of(3);
    EXPECT_TRUE(readings(few, 0.0, 0.0).empty());
}

TEST(GatherSchedule, ReadsAFewTimesATickAndAlwaysBeforeIt) {
    GatherSchedule schedule = after_a_period_of(400);
    const std::vector<double> at = readings(schedule, 60e-6, 200e-6);
    EXPECT_GE(at.size(), 1U);
    EXPECT_LE(at.size(), 5U);
    EXPECT_LT(at.back() + 200e-6, kGatherTick_s);
    EXPECT_GT(at.front(), 0.9 * kGatherTick_s);
}

/// As late as the thread was woken before, it is taken to be again, twice over.
TEST(GatherSchedule, BeginsTheEarlierTheLaterItWasWoken) {
    GatherSchedule schedule = after_a_period_of(400);
    schedule.note_reading(0.0, 4e-3);
    const std::vector<double> at = readings(schedule, 4e-3, 0.0);
    ASSERT_FALSE(at.empty());
    EXPECT_LT(at.front(), kGatherTick_s - 4e-3);
    // And forgets it: a hundredth is left after the logarithm of that over that of its memory.
    for (int tick = 1; tick <= 228; ++tick) {
        schedule.begin_tick(400U + 400U * static_cast<unsigned>(tick), tick * kGatherTick_s);
    }
    EXPECT_NEAR(schedule.hold_until(0.0, kGatherTick_s), kGatherTick_s - 0.5e-3, 2 * 0.01 * 4e-3);
}

TEST(GatherSchedule, ReadsBeforeAQuarterOfTheBufferCouldBeFull) {
    GatherSchedule schedule = after_a_period_of(5120);  // ten quarters, at a page for each
    const double until = schedule.hold_until(0.0, kGatherTick_s);
    EXPECT_NEAR(until, 0.1 * kGatherTick_s, 1e-9);
    GatherSchedule flood = after_a_period_of(512 * 1000);
    EXPECT_EQ(flood.hold_until(0.0, kGatherTick_s), 0.0);
}

TEST(GatherSchedule, LetsNothingWaitForATickThatIsLate) {
    GatherSchedule schedule = after_a_period_of(400);
    EXPECT_EQ(schedule.hold_until(1.0, 1.0), 1.0);
    EXPECT_EQ(schedule.hold_until(1.0, 0.5), 1.0);
}

}  // namespace
}  // namespace zoned::net
