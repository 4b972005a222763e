#include "client-sim/link/conditioner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace zoned::link {
namespace {

Bytes numbered(std::uint32_t n) {
    return {static_cast<std::uint8_t>(n),
            static_cast<std::uint8_t>(n >> 8),
            static_cast<std::uint8_t>(n >> 16)};
}

std::uint32_t number_of(const Bytes& b) {
    return static_cast<std::uint32_t>(b[0]) | static_cast<std::uint32_t>(b[1]) << 8 |
           static_cast<std::uint32_t>(b[2]) << 16;
}

struct Arrival {
    std::uint32_t number;
    double sent_s;
    double due_s;
};

std::vector<Arrival> run(Conditioner& c, std::uint32_t count, double gap_s) {
    for (std::uint32_t i = 0; i < count; ++i) {
        c.push(static_cast<double>(i) * gap_s, numbered(i));
    }
    std::vector<Arrival> arrivals;
    Bytes bytes;
    for (;;) {
        const double due = c.next_due_s();
        if (!c.pop_due(due, bytes)) {
            return arrivals;
        }
        const std::uint32_t n = number_of(bytes);
        arrivals.push_back({n, n * gap_s, due});
    }
}

TEST(Conditioner, HandsEverythingThroughAtOnceWhenNothingIsSet) {
    Conditioner c({}, Conditioner::Mode::kDatagrams, 1);
    EXPECT_FALSE(ConditionerSettings{}.active());
    const auto arrivals = run(c, 1000, 0.01);
    ASSERT_EQ(arrivals.size(), 1000U);
    for (std::uint32_t i = 0; i < 1000; ++i) {
        EXPECT_EQ(arrivals[i].number, i);
        EXPECT_EQ(arrivals[i].due_s, arrivals[i].sent_s);
    }
}

TEST(Conditioner, LosesAndDoublesAsOftenAsItSays) {
    ConditionerSettings s;
    s.loss = 0.05;
    s.duplicate = 0.02;
    Conditioner c(s, Conditioner::Mode::kDatagrams, 3);
    const std::uint32_t count = 100000;
    const auto arrivals = run(c, count, 0.001);
    // Binomial counts: five standard deviations, sqrt(n p (1 - p)), fail once in 10^6 seeds.
    const double lost_sigma = std::sqrt(count * 0.05 * 0.95);
    EXPECT_NEAR(static_cast<double>(c.lost()), 0.05 * count, 5.0 * lost_sigma);
    const double kept = 0.95 * count;
    EXPECT_NEAR(static_cast<double>(c.doubled()), 0.02 * kept, 5.0 * std::sqrt(kept * 0.02 * 0.98));
    EXPECT_EQ(arrivals.size(), count - c.lost() + c.doubled());
}

TEST(Conditioner, DelaysWithinTheJitterOnBothSides) {
    ConditionerSettings s;
    s.delay_s = 0.060;
    s.jitter_s = 0.020;
    Conditioner c(s, Conditioner::Mode::kDatagrams, 3);
    double sum = 0.0;
    double least = 1.0;
    double most = 0.0;
    const auto arrivals = run(c, 20000, 0.001);
    for (const Arrival& a : arrivals) {
        const double delay = a.due_s - a.sent_s;
        least = std::min(least, delay);
        most = std::max(most, delay);
        sum += delay;
    }
    EXPECT_GE(least, 0.040 - 1e-9);
    EXPECT_LE(most, 0.080 + 1e-9);
    // Uniform on 40 ms: sigma of the mean is 40 ms / sqrt(12 n) = 0.08 ms; five of them.
    EXPECT_NEAR(sum / 20000.0, 0.060, 0.0004);
    // Both ends are reached: the chance that no draw falls into the last hundredth is (0.99)^20000.
    EXPECT_LT(least, 0.0404);
    EXPECT_GT(most, 0.0796);
}

TEST(Conditioner, NeverDelaysBelowZero) {
    ConditionerSettings s;
    s.delay_s = 0.001;
    s.jitter_s = 0.050;
    Conditioner c(s, Conditioner::Mode::kDatagrams, 3);
    for (const Arrival& a : run(c, 2000, 0.001)) {
        EXPECT_GE(a.due_s, a.sent_s);
    }
}

TEST(Conditioner, HoldsReorderedDatagramsBackByOneToTwoTicks) {
    ConditionerSettings s;
    s.delay_s = 0.010;
    s.reorder = 0.05;
    Conditioner c(s, Conditioner::Mode::kDatagrams, 9);
    std::uint64_t held = 0;
    for (const Arrival& a : run(c, 20000, 0.005)) {
        const double extra = a.due_s - a.sent_s - 0.010;
        if (extra > 1e-9) {
            ++held;
            EXPECT_GE(extra, s.reorder_hold_s - 1e-9);
            EXPECT_LE(extra, 2.0 * s.reorder_hold_s + 1e-9);
        }
    }
    EXPECT_EQ(held, c.held_back());
    EXPECT_NEAR(static_cast<double>(held), 1000.0, 5.0 * std::sqrt(20000 * 0.05 * 0.95));
}

TEST(Conditioner, KeepsFramesInOrderAndLosesNone) {
    ConditionerSettings s;
    s.delay_s = 0.060;
    s.jitter_s = 0.060;
    s.loss = 0.5;
    s.duplicate = 0.5;
    s.reorder = 0.5;
    Conditioner c(s, Conditioner::Mode::kFrames, 4);
    const auto arrivals = run(c, 5000, 0.001);
    ASSERT_EQ(arrivals.size(), 5000U);
    for (std::uint32_t i = 0; i < 5000; ++i) {
        EXPECT_EQ(arrivals[i].number, i);
    }
}

TEST(Conditioner, LosesDatagramsAndHoldsFramesDuringOutages) {
    ConditionerSettings s;
    s.outage_every_s = 10.0;
    s.outage_length_s = 1.0;
    Conditioner datagrams(s, Conditioner::Mode::kDatagrams, 1);
    Conditioner frames(s, Conditioner::Mode::kFrames, 2);
    for (const double at : {0.5, 9.9, 10.0, 10.9, 11.1}) {
        datagrams.push(at, {});
        frames.push(at, {});
    }
    EXPECT_EQ(datagrams.lost(), 2U);
    Bytes bytes;
    int before = 0;
    while (frames.pop_due(10.95, bytes)) {
        ++before;
    }
    EXPECT_EQ(before, 2);
    int after = 0;
    while (frames.pop_due(11.2, bytes)) {
        ++after;
    }
    EXPECT_EQ(after, 3);
}

TEST(Conditioner, IsTheSameForTheSameSeedAndOtherForAnother) {
    ConditionerSettings s;
    s.delay_s = 0.05;
    s.jitter_s = 0.05;
    s.loss = 0.1;
    s.duplicate = 0.1;
    s.reorder = 0.1;
    const auto trace = [&](std::uint64_t seed, std::uint64_t stream) {
        s.seed = seed;
        Conditioner c(s, Conditioner::Mode::kDatagrams, stream);
        std::vector<std::pair<std::uint32_t, double>> out;
        for (const Arrival& a : run(c, 500, 0.01)) {
            out.emplace_back(a.number, a.due_s);
        }
        return out;
    };
    EXPECT_EQ(trace(1, 1), trace(1, 1));
    EXPECT_NE(trace(1, 1), trace(2, 1));
    EXPECT_NE(trace(1, 1), trace(1, 2));
}

}  // namespace
}  // namespace zoned::link
