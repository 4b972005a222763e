// AckDelay: packets that come late after all, and probes that stay without an answer.
#include "server/replication/delivery/ack_delay.h"

#include <gtest/gtest.h>

namespace zoned::replication {
namespace {

constexpr float kTick_s = 1.0F / 30.0F;
constexpr Tick kPatience = 4;

TEST(AckDelay, TakesAPacketThatComesAfterAllForReordering) {
    AckDelay delay;
    delay.begin_tick(0, kTick_s, kPatience, kPatience);
    EXPECT_FALSE(delay.passed_over(2, 1));
    EXPECT_TRUE(delay.passed_over(3, 1));
    delay.on_acked({10, 0, 5, true, false});
    delay.begin_tick(1, kTick_s, kPatience, kPatience);
    EXPECT_FALSE(delay.passed_over(5, 1));
    EXPECT_TRUE(delay.passed_over(6, 1));
    EXPECT_TRUE(delay.passed_over(1, kPatience + 1)) << "time passes it over too";
    delay.begin_tick(61, kTick_s, kPatience, kPatience);
    EXPECT_TRUE(delay.passed_over(3, 1)) << "forgotten after two seconds";
}

TEST(AckDelay, LearnsNoReorderingFromPacketsThatWereNotGivenUp) {
    AckDelay delay;
    delay.on_acked({10, 0, 5, false, false});
    delay.begin_tick(1, kTick_s, kPatience, kPatience);
    EXPECT_TRUE(delay.passed_over(3, 1));
}

TEST(AckDelay, WaitsTwiceAsLongAfterAProbeWithoutAnswer) {
    AckDelay delay;
    delay.begin_tick(100, kTick_s, kPatience, kPatience);
    EXPECT_FALSE(delay.probe(100, kPatience));
    EXPECT_TRUE(delay.probe(100, kPatience + 1));
    delay.begin_tick(101 + kPatience, kTick_s, kPatience, kPatience);
    EXPECT_FALSE(delay.probe(101 + kPatience, 2 * kPatience));
    EXPECT_TRUE(delay.probe(101 + kPatience, 2 * kPatience + 1));
    delay.on_acked({10, 100, 0, false, false});
    delay.begin_tick(102 + kPatience, kTick_s, kPatience, kPatience);
    EXPECT_FALSE(delay.probe(102 + kPatience, kPatience + 1))
        << "so late one came: none is overdue";
    EXPECT_TRUE(delay.probe(102 + kPatience, kPatience + 2)) << "an answer ends the doubling";
}

TEST(AckDelay, IsLateWhereAcknowledgementsTakeMuchLongerThanTheSoonest) {
    AckDelay delay;
    EXPECT_FALSE(delay.late());
    delay.on_acked({1, 0, 0, false, false});
    delay.begin_tick(3, kTick_s, kPatience, kPatience);
    EXPECT_FALSE(delay.late());
    delay.on_acked({2, 20, 0, false, false});
    delay.begin_tick(20 + 2 * 3 + 20, kTick_s, kPatience, kPatience);
    EXPECT_FALSE(delay.late());
    delay.on_acked({3, 60, 0, false, false});
    delay.begin_tick(60 + 2 * 3 + 21, kTick_s, kPatience, kPatience);
    EXPECT_TRUE(delay.late());
    delay.begin_tick(160, kTick_s, kPatience, kPatience);
    EXPECT_FALSE(delay.late()) << "two seconds later";
}

}  // namespace
}  // namespace zoned::replication
