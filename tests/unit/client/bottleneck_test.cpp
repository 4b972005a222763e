#include "client-sim/link/conditioner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace zoned::link {
namespace {

constexpr double kRate = 32000.0;  // bytes per second
constexpr double kExact = 1e-9;    // a few roundings of times around 10 s

ConditionerSettings narrow(double queue_s = 0.25) {
    ConditionerSettings s;
    s.bottleneck_down_bytes_per_s = kRate;
    s.bottleneck_queue_s = queue_s;
    return s;
}

/// Everything that comes out until `until_s`, in order, with its time.
std::vector<double> drain(Conditioner& c, double until_s) {
    std::vector<double> times;
    Bytes bytes;
    for (double due = c.next_due_s(); due <= until_s; due = c.next_due_s()) {
        if (c.pop_due(due, bytes)) {
            times.push_back(due);
        }
    }
    return times;
}

TEST(Bottleneck, CarriesABurstAtItsRateInOrder) {
    Conditioner c(narrow(), Conditioner::Mode::kDatagrams, 1, Direction::kDown);
    for (std::uint8_t i = 0; i < 5; ++i) {
        c.push(1.0, Bytes(972, i));  // 1,000 bytes with headers: 31.25 ms
    }
    const auto times = drain(c, 10.0);
    ASSERT_EQ(times.size(), 5U);
    for (std::size_t i = 0; i < times.size(); ++i) {
        EXPECT_NEAR(times[i], 1.0 + 0.03125 * static_cast<double>(i + 1), kExact);
    }
    const BottleneckMeter meter = c.bottleneck(10.0);
    EXPECT_EQ(meter.carried, 5U);
    EXPECT_EQ(meter.carried_bytes, 5000.0);
    EXPECT_NEAR(meter.wait_s.max(), 4 * 0.03125, kExact);
    EXPECT_NEAR(meter.utilisation(), 5000.0 / (10.0 * kRate), kExact);
}

TEST(Bottleneck, DropsWhatWouldWaitTooLong) {
    Conditioner c(narrow(0.1), Conditioner::Mode::kDatagrams, 1, Direction::kDown);
    for (int i = 0; i < 10; ++i) {
        c.push(0.0, Bytes(972));
    }
    // Waits of 0, 31.25, 62.5 and 93.75 ms are within 100 ms.
    EXPECT_EQ(drain(c, 10.0).size(), 4U);
    EXPECT_EQ(c.bottleneck(10.0).dropped, 6U);
}

TEST(Bottleneck, DeliversExactlyItsRateWhenOffered150Percent) {
    Conditioner c(narrow(0.05), Conditioner::Mode::kDatagrams, 1, Direction::kDown);
    std::size_t carried = 0;
    Bytes bytes;
    const double gap_s = 1000.0 / (1.5 * kRate);
    double now = 0.0;
    while (now < 20.0) {
        c.push(now, Bytes(972));
        now += gap_s;
        while (c.pop_due(now, bytes)) {
            ++carried;
        }
    }
    // Up to one message may still be on its path, and one wait is missing in the beginning.
    EXPECT_NEAR(static_cast<double>(carried), 20.0 * kRate / 1000.0, 3.0);
    const BottleneckMeter meter = c.bottleneck(now);
    EXPECT_NEAR(meter.utilisation(), 1.0, 0.005);
    EXPECT_LE(meter.wait_s.max(), 0.05 + kExact);
    EXPECT_NEAR(static_cast<double>(meter.dropped), 20.0 * 0.5 * kRate / 1000.0, 6.0);
}

TEST(Bottleneck, GoesOnAtTheNewRateInTheMiddleOfAMessage) {
    Conditioner c(narrow(), Conditioner::Mode::kDatagrams, 1, Direction::kDown);
    c.push(0.0, Bytes(972));
    c.push(0.0, Bytes(972));
    // After 20 ms 640 of 1,000 bytes have left; the rest goes at half the rate.
    c.set_bottleneck(0.020, 0.5 * kRate);
    const auto times = drain(c, 10.0);
    ASSERT_EQ(times.size(), 2U);
    EXPECT_NEAR(times[0], 0.020 + 360.0 / 16000.0, kExact);
    EXPECT_NEAR(times[1], times[0] + 1000.0 / 16000.0, kExact);
    EXPECT_NEAR(c.bottleneck(1.0).capacity_bytes, 0.020 * kRate + 0.98 * 16000.0, 1e-6);
}

TEST(Bottleneck, ComesBeforeDelayAndLossOnThePath) {
    ConditionerSettings s = narrow();
    s.delay_s = 0.5;
    s.loss = 0.5;
    Conditioner c(s, Conditioner::Mode::kDatagrams, 1, Direction::kDown);
    const int count = 1000;
    std::size_t arrived = 0;
    for (int i = 0; i < count; ++i) {
        c.push(0.04 * i, Bytes(972));
        for (const double at : drain(c, 0.04 * i)) {
            // No message waits at 1,000 bytes per 40 ms: transmission, then the delay.
            EXPECT_NEAR(std::fmod(at, 0.04), std::fmod(0.53125, 0.04), 1e-6);
            ++arrived;
        }
    }
    arrived += drain(c, 100.0).size();
    EXPECT_EQ(arrived + c.lost(), static_cast<std::size_t>(count));
    // Three standard deviations of a binomial: 3 sqrt(1000 / 4) = 47.
    EXPECT_NEAR(static_cast<double>(arrived), 500.0, 47.0);
    // Messages lost behind the bottleneck have used it.
    EXPECT_EQ(c.bottleneck(100.0).carried, static_cast<std::uint64_t>(count));
}

TEST(Bottleneck, LimitsOneDirectionAndNoFrames) {
    const ConditionerSettings s = narrow();
    EXPECT_TRUE(s.active());
    Conditioner up(s, Conditioner::Mode::kDatagrams, 1, Direction::kUp);
    Conditioner frames(s, Conditioner::Mode::kFrames, 1, Direction::kDown);
    for (int i = 0; i < 100; ++i) {
        up.push(0.0, Bytes(1000));
        frames.push(0.0, Bytes(1000));
    }
    EXPECT_EQ(drain(up, 0.0).size(), 100U);
    EXPECT_EQ(drain(frames, 0.0).size(), 100U);
}

TEST(Histogram, MergesAsIfAllHadBeenAddedToOne) {
    core::Histogram a;
    core::Histogram b;
    core::Histogram both;
    for (int i = 0; i < 1000; ++i) {
        const double value = std::pow(1.02, i % 700);
        (i % 3 == 0 ? a : b).add(value);
        both.add(value);
    }
    a.merge(b);
    EXPECT_EQ(a.count(), both.count());
    EXPECT_EQ(a.max(), both.max());
    EXPECT_EQ(a.percentile(0.5), both.percentile(0.5));
    EXPECT_EQ(a.percentile(0.99), both.percentile(0.99));
    EXPECT_NEAR(a.mean(), both.mean(), 1e-9 * both.mean());
}

}  // namespace
}  // namespace zoned::link
