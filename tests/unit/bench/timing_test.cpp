#include "tests/bench/timing.h"

#include "tests/bench/cpu_clock.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace zoned::bench {
namespace {

/// Uses so much CPU time, as the thread's clock has it.
void burn_us(double us) {
    const auto end = thread_cpu_ns() + static_cast<std::int64_t>(us * 1e3);
    while (thread_cpu_ns() < end) {
    }
}

/// The log of a run, for the test.
struct Log {
    int built = 0;
    int frames = 0;
    int observed = 0;
    std::vector<int>* order = nullptr;
    int label = 0;
};

class BurningTrial : public Trial {
  public:
    BurningTrial(Log& log, double us) : log_(log), us_(us) { ++log_.built; }

    void frame() override {
        ++log_.frames;
        if (log_.order != nullptr) {
            log_.order->push_back(log_.label);
        }
        burn_us(us_);
    }

    void observe() override { ++log_.observed; }

  private:
    Log& log_;
    double us_;
};

Contender contender(Log& log, double us) {
    return {"", [&log, us] {
                return std::make_unique<BurningTrial>(log, us);
            }};
}

TEST(TimeInterleaved, TellsTheTimeOfAFrame) {
    Log fast;
    Log slow;
    const std::vector<Contender> both{contender(fast, 50.0), contender(slow, 200.0)};
    const std::vector<Timing> times =
        time_interleaved(both, {0, 50, 3}, [](std::size_t, Trial&) {});
    // A frame takes at least the time it burns. Reading the clock in its loop adds to that, well
    // below half of it even where the clock is slow.
    EXPECT_GE(times[0].p50_us, 49.0);
    EXPECT_LT(times[0].p50_us, 75.0);
    EXPECT_GE(times[1].p50_us, 199.0);
    EXPECT_LT(times[1].p50_us, 300.0);
    EXPECT_GE(times[1].p99_us, times[1].p50_us);
}

TEST(TimeInterleaved, ObservesEveryFrameOfTheFirstRunOnly) {
    Log log;
    const std::vector<Contender> one{contender(log, 30.0)};
    int finished = 0;
    time_interleaved(one, {5, 20, 3}, [&finished](std::size_t, Trial&) { ++finished; });
    EXPECT_EQ(log.observed, 25);
    EXPECT_EQ(finished, 1);
    EXPECT_EQ(log.built, 3);  // frames are long: the observed run is one of the timed three
    EXPECT_EQ(log.frames, 3 * 25);
}

TEST(TimeInterleaved, RunsNothingAgainThatTookLongEnough) {
    Log log;
    const std::vector<Contender> one{contender(log, 30.0)};
    time_interleaved(one, {0, 20, 3, 1e-4}, [](std::size_t, Trial&) {});
    EXPECT_EQ(log.built, 1) << "20 frames burn 600 us";
    log.built = 0;
    time_interleaved(one, {0, 20, 3, 1e4}, [](std::size_t, Trial&) {});
    EXPECT_EQ(log.built, 3);
}

TEST(TimeInterleaved, GroupsFramesThatAreShortAgainstTheClock) {
    Log log;
    const std::vector<Contender> one{contender(log, 0.0)};
    const std::vector<Timing> times =
        time_interleaved(one, {0, 1000, 2}, [](std::size_t, Trial&) {});
    EXPECT_EQ(log.built, 3);  // the observed run was no timed one
    EXPECT_EQ(log.frames, 3 * 1000);
    EXPECT_LT(times[0].p50_us, 20.0);
}

TEST(TimeInterleaved, LetsContendersTakeTurns) {
    std::vector<int> order;
    Log a;
    Log b;
    a.order = b.order = &order;
    b.label = 1;
    const std::vector<Contender> both{contender(a, 30.0), contender(b, 30.0)};
    time_interleaved(both, {0, 48, 1}, [](std::size_t, Trial&) {});
    int changes = 0;
    for (std::size_t i = 1; i < order.size(); ++i) {
        changes += order[i] != order[i - 1] ? 1 : 0;
    }
    EXPECT_GE(changes, 20);  // twelve turns each
}

TEST(TimeInterleaved, LetsEachComeAfterEachOtherEquallyOften) {
    for (std::size_t count = 3; count <= 9; ++count) {
        const std::size_t turns = count % 2 == 0 ? count : 2 * count;
        std::vector<int> after(count * count, 0);
        for (std::size_t turn = 0; turn < turns; ++turn) {
            const std::vector<std::size_t> order = order_of_turn(turn, count);
            std::vector<std::size_t> sorted = order;
            std::sort(sorted.begin(), sorted.end());
            for (std::size_t i = 0; i < count; ++i) {
                ASSERT_EQ(sorted[i], i) << "each has one turn";
            }
            for (std::size_t i = 1; i < count; ++i) {
                ++after[order[i - 1] * count + order[i]];
            }
        }
        const int times = count % 2 == 0 ? 1 : 2;
        for (std::size_t pair = 0; pair < count * count; ++pair) {
            const bool itself = pair / count == pair % count;
            EXPECT_EQ(after[pair], itself ? 0 : times) << count << ": " << pair;
        }
    }
    EXPECT_EQ(order_of_turn(5, 2), (std::vector<std::size_t>{0, 1}));
    EXPECT_EQ(order_of_turn(5, 1), (std::vector<std::size_t>{0}));
    EXPECT_TRUE(order_of_turn(5, 0).empty());
}

}  // namespace
}  // namespace zoned::bench
