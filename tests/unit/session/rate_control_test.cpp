#include "server/session/datagrams/rate_control.h"

#include "server/session/datagrams/pacer.h"
#include "shared/core/rng.h"
#include "shared/wire/packet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

namespace zoned::session {
namespace {

constexpr double kTick_s = 1.0 / 30.0;
constexpr double kRate = 32000.0;  // 256 kbit/s

/// A path with one link, a drop-tail queue, delay and jitter; a sender that fills its rate in every
/// tick; a client that answers at its own ticks.
class Path {
  public:
    explicit Path(const RateSettings& settings) : control(settings) {}

    /// Runs until `until_s`; waits and carried bytes count packets sent from `measure_from_s` on.
    void run(double until_s, double measure_from_s) {
        waits.clear();
        carried = 0.0;
        measured_from_s = measure_from_s;
        for (; now < until_s; now += kTick_s) {
            answer();
            tokens = std::min(tokens + control.bytes_per_s() * kTick_s,
                              std::max(512.0, 1.5 * control.bytes_per_s() * kTick_s));
            double bytes = std::min({tokens, demand * kTick_s + left, 1228.0});
            left = std::min(left + demand * kTick_s - bytes, 3000.0);
            while (bytes > 100.0) {
                send(bytes);
                tokens -= bytes;
                bytes = std::min({tokens, left, 1228.0});
                left -= std::min(left, bytes);
            }
        }
    }

    [[nodiscard]] double wait_p95() {
        std::sort(waits.begin(), waits.end());
        return waits.empty() ? 0.0 : waits[waits.size() * 95 / 100];
    }

    [[nodiscard]] double used() const { return carried / (capacity * (now - measured_from_s)); }

    RateControl control;
    double capacity = kRate;
    double queue_limit_s = 0.5;
    double delay_s = 0.03;
    double jitter_s = 0.0;
    double loss = 0.0;
    double demand = 1e6;
    double clock_offset_s = 1234.5;
    double clock_drift = 0.0;
    double now = 0.0;
    std::vector<double> waits;
    double carried = 0.0;

  private:
    struct Datagram {
        std::uint64_t sequence = 0;
        double sent_s = 0.0;
        double arrival_s = 0.0;
    };

    struct Answer {
        double at_s = 0.0;
        std::uint64_t newest = 0;
        std::uint32_t bits = 0;
        std::uint16_t one_way = 0;
    };

    static std::uint32_t us(double s) {
        return static_cast<std::uint32_t>(static_cast<std::uint64_t>(std::floor(s * 1e6)));
    }

    void send(double bytes) {
        const std::uint64_t sequence = ++sequence_;
        const double at = pacer_.due_s(now, bytes, control.bytes_per_s(), kTick_s);
        control.on_sent(sequence, static_cast<std::size_t>(bytes), at, us(at));
        const double start = std::max(at, free_s_);
        if (start - at > queue_limit_s) {
            return;
        }
        free_s_ = start + bytes / capacity;
        if (now >= measured_from_s) {
            waits.push_back(start - at);
            carried += bytes;
        }
        if (static_cast<double>(rng_.unit()) < loss) {
            return;
        }
        const double shift = jitter_s * (2.0 * static_cast<double>(rng_.unit()) - 1.0);
        under_way_.push_back({sequence, at, free_s_ + std::max(0.0, delay_s + shift)});
    }

    /// The client's reports of received packets, sent at its ticks and delayed on their path.
    void answer() {
        std::sort(under_way_.begin(), under_way_.end(), [](const auto& a, const auto& b) {
            return a.arrival_s < b.arrival_s;
        });
        while (!under_way_.empty() && under_way_.front().arrival_s <= now) {
            const Datagram d = under_way_.front();
            under_way_.pop_front();
            acks_.on_received(d.sequence);
            if (acks_.newest() == d.sequence) {
                const double client_s = clock_offset_s + d.arrival_s * (1.0 + clock_drift);
                one_way_ = wire::one_way_128us(us(client_s), us(d.sent_s));
            }
        }
        if (acks_.newest() != 0) {
            answers_.push_back({now + delay_s, acks_.newest(), acks_.bits(), one_way_});
        }
        while (!answers_.empty() && answers_.front().at_s <= now) {
            const Answer& a = answers_.front();
            control.on_feedback(a.newest, a.bits, a.one_way, 2.0 * delay_s, now);
            answers_.pop_front();
        }
    }

    Pacer pacer_;
    std::uint64_t sequence_ = 0;
    double free_s_ = 0.0;
    double tokens = 0.0;
    double left = 0.0;
    double measured_from_s = 0.0;
    std::deque<Datagram> under_way_;
    std::deque<Answer> answers_;
    wire::AckTracker acks_;
    std::uint16_t one_way_ = 0;
    core::Rng rng_{5};
};

RateSettings settings(double ceiling = 125000.0) {
    RateSettings s;
    s.ceiling = ceiling;
    return s;
}

TEST(RateControl, FillsABottleneckWithAShortQueue) {
    for (const double delay_s : {0.005, 0.03, 0.1}) {
        Path path(settings());
        path.delay_s = delay_s;
        path.run(60.0, 5.0);
        EXPECT_LT(path.wait_p95(), 0.050) << delay_s;
        EXPECT_GT(path.used(), 0.85) << delay_s;
    }
}

TEST(RateControl, FindsTheNewRateWithinFiveSeconds) {
    Path path(settings());
    path.run(20.0, 15.0);
    path.capacity = 2.0 * kRate;
    path.run(40.0, 25.0);
    EXPECT_GT(path.used(), 0.85);
    EXPECT_LT(path.wait_p95(), 0.050);
    path.capacity = kRate;
    path.run(60.0, 45.0);
    EXPECT_GT(path.used(), 0.85);
    EXPECT_LT(path.wait_p95(), 0.050);
    path.capacity = 4.0 * kRate;
    path.run(80.0, 65.0);
    EXPECT_GT(path.used(), 0.85);
    path.capacity = 0.5 * kRate;
    path.run(100.0, 85.0);
    EXPECT_GT(path.used(), 0.85);
    // At 16 kB/s a full datagram takes 75 ms: one in front is the least queue there is.
    EXPECT_LT(path.wait_p95(), 0.100);
}

TEST(RateControl, KeepsTheCeilingWhereNothingIsInTheWay) {
    for (const double jitter_s : {0.0, 0.033}) {
        Path path(settings(16000.0));
        path.capacity = 1e9;
        path.delay_s = 0.1;
        path.jitter_s = jitter_s;
        path.run(60.0, 5.0);
        EXPECT_GT(path.control.bytes_per_s(), 0.8 * 16000.0) << jitter_s;
    }
}

/// A path that carries everything. Each feedback is a false alarm by jitter with a chance of 1e-4
/// (rate_control.cpp). The 3900 feedbacks of a run hold 0.4 of them, and hardly more than two. One
/// cut takes at most half of the rate at once. Where that leaves less than half of the requested
/// rate, growth by 10 % a second makes up for it in ln 2 / ln 1.1 = 7.3 s. So after one such cut
/// fewer than 15 half seconds are starved.
/// On a wide path a datagram of a thousand bytes takes no longer than one of a hundred.
TEST(RateControl, TakesNoSmallDatagramAfterLargeOnesForAQueue) {
    Path path(settings(16000.0));
    path.capacity = 12.5e6;
    for (int burst = 0; burst < 60; ++burst) {
        path.demand = 1e6;
        path.run(path.now + 2.5 * kTick_s, 0.0);
        path.demand = 3100.0;
        path.run(path.now + 1.0, 0.0);
    }
    EXPECT_EQ(path.control.cuts(), 0U);
    EXPECT_EQ(path.control.bytes_per_s(), 16000.0);
}

TEST(RateControl, IsNotStarvedByJitterOrByLossThatItDoesNotCause) {
    constexpr int kOneRecovery = 15;
    for (const double loss : {0.0, 0.05, 0.3}) {
        for (const double jitter_s : {0.033, 0.1}) {
            Path path(settings(16000.0));
            path.capacity = 1e9;
            path.delay_s = 0.1;
            path.jitter_s = jitter_s;
            path.loss = loss;
            path.demand = 8000.0;
            int starved = 0;
            double sum = 0.0;
            for (int half_seconds = 0; half_seconds < 240; ++half_seconds) {
                path.run(10.0 + 0.5 * half_seconds, 0.0);
                starved += path.control.bytes_per_s() < 0.5 * path.demand ? 1 : 0;
                sum += path.control.bytes_per_s();
            }
            EXPECT_GT(sum / 240.0, path.demand) << "loss " << loss << " jitter " << jitter_s;
            EXPECT_LT(starved, kOneRecovery) << "loss " << loss << " jitter " << jitter_s;
        }
    }
}

TEST(RateControl, GivesWayWhereAQueueTooShortToBeFeltDropsInstead) {
    Path path(settings());
    path.queue_limit_s = 0.005;
    path.run(60.0, 10.0);
    EXPECT_LT(path.control.loss(), 0.25);
    EXPECT_LT(path.control.bytes_per_s(), 1.4 * kRate);
    EXPECT_GT(path.control.bytes_per_s(), 0.6 * kRate);
}

TEST(RateControl, TakesALongerPathForWhatItIs) {
    Path path(settings(16000.0));
    path.capacity = 1e9;
    path.run(10.0, 5.0);
    path.delay_s = 0.15;  // a route change: no queue of ours
    path.run(40.0, 30.0);
    EXPECT_GT(path.control.bytes_per_s(), 0.85 * 16000.0);
}

TEST(RateControl, NeedsNoClocksThatAgreeOrRunAlike) {
    for (const double drift : {-100e-6, 100e-6}) {
        Path path(settings());
        path.clock_drift = drift;
        path.clock_offset_s = 86400.0 * 365.0;
        path.run(200.0, 10.0);
        EXPECT_GT(path.used(), 0.85) << drift;
        EXPECT_LT(path.wait_p95(), 0.050) << drift;
    }
}

TEST(RateControl, HalvesItsRateForEverySecondOfSilence) {
    Path path(settings(16000.0));
    path.capacity = 1e9;
    path.run(5.0, 5.0);
    double now = path.now;
    path.control.on_sent(1'000'000, 500, now, 0);
    EXPECT_FALSE(path.control.on_silence(now + 0.9));
    EXPECT_TRUE(path.control.on_silence(now + 1.1));
    EXPECT_FALSE(path.control.on_silence(now + 1.5));
    EXPECT_TRUE(path.control.on_silence(now + 2.2));
    EXPECT_NEAR(path.control.bytes_per_s(), 4000.0, 1.0);
}

TEST(RateControl, StaysAtTheCeilingWhenItIsOff) {
    RateSettings off = settings(50000.0);
    off.on = false;
    Path path(off);
    path.run(10.0, 5.0);
    EXPECT_EQ(path.control.bytes_per_s(), 50000.0);
    EXPECT_GT(path.wait_p95(), 0.3);  // the queue is full: the other tests prevent this
}

TEST(Pacer, SpreadsABurstOverLessThanATick) {
    Pacer pacer;
    EXPECT_EQ(pacer.due_s(10.0, 1200.0, 32000.0, kTick_s), 10.0);
    const double second = pacer.due_s(10.0, 1200.0, 32000.0, kTick_s);
    EXPECT_NEAR(second, 10.0 + 1200.0 / 64000.0, 1e-12);
    for (int i = 0; i < 10; ++i) {
        const double due = pacer.due_s(10.0, 1200.0, 32000.0, kTick_s);
        EXPECT_LE(due, 10.0 + 0.8 * kTick_s + 1e-12);
        EXPECT_GE(due, second);
    }
}

TEST(Pacer, LetsSmallDatagramsThroughAtOnce) {
    Pacer pacer;
    for (int i = 0; i < 10; ++i) {
        EXPECT_EQ(pacer.due_s(10.0, 60.0, 32000.0, kTick_s), 10.0);
    }
}

}  // namespace
}  // namespace zoned::session
