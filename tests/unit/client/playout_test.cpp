#include "client-sim/view/playout.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace zoned::view {
namespace {

constexpr double kTickS = 1.0 / 30.0;
const Tick kLead = Playout::lead_ticks(kTickS);

/// `ticks` of a network whose updates come `base` ticks late and up to `jitter` more. Returns the
/// share of packets that came after their tick had been displayed, of the second half.
double late_share(Playout& playout, Tick& now, int ticks, Tick base, Tick jitter, core::Rng& rng) {
    std::vector<std::pair<Tick, Tick>> under_way;  // arrival, tick
    int late = 0;
    int counted = 0;
    const Tick end = now + ticks;
    const Tick half = now + ticks / 2;
    for (; now < end; ++now) {
        under_way.emplace_back(
            now + base + static_cast<Tick>(rng.below(static_cast<std::uint32_t>(jitter) + 1)), now);
        for (auto it = under_way.begin(); it != under_way.end();) {
            if (it->first > now) {
                ++it;
                continue;
            }
            playout.on_update(now - it->second);
            if (now > half) {
                ++counted;
                late += playout.position() >= static_cast<double>(it->second + 1) ? 1 : 0;
            }
            it = under_way.erase(it);
        }
        playout.advance(now);
    }
    return static_cast<double>(late) / std::max(1, counted);
}

TEST(Playout, StaysBehindByTheQuantileOfTheLateness) {
    core::Rng rng(1);
    Playout playout(kTickS);
    Tick now = 100;
    EXPECT_LE(late_share(playout, now, 1200, 2, 0, rng), 0.0);
    EXPECT_EQ(playout.delay(), 2 + kLead);
    EXPECT_NEAR(static_cast<double>(now - 1) - playout.position(), 2.0 + kLead, 0.05);
    // Jitter of six ticks: all but a hundredth of the updates are in time. The slack for 600
    // samples is three standard deviations of sqrt(0.01 / 600).
    EXPECT_LE(late_share(playout, now, 1200, 2, 6, rng), 0.01 + 0.0122);
    EXPECT_GE(playout.delay(), 7 + kLead);
    EXPECT_LE(playout.delay(), 8 + kLead);
    // And back again when the network has calmed down.
    late_share(playout, now, 1200, 2, 0, rng);
    EXPECT_EQ(playout.delay(), 2 + kLead);
    EXPECT_NEAR(static_cast<double>(now - 1) - playout.position(), 2.0 + kLead, 0.05);
}

TEST(Playout, NeverRunsBackwardsNorFasterThanItSlews) {
    core::Rng rng(2);
    Playout playout(kTickS);
    double before = -1.0;
    for (Tick now = 0; now < 5000; ++now) {
        // Regimes of lateness between 1 and 40 ticks.
        playout.on_update(1 + static_cast<Tick>(rng.below(now / 500 % 2 == 0 ? 3 : 25)));
        playout.advance(now);
        if (now > 0) {
            const double step = playout.position() - before;
            EXPECT_GE(step, 1.0 - Playout::kSlew - 1e-9);
            EXPECT_LE(step, 1.0 + Playout::kSlew + 1e-9);
        }
        before = playout.position();
    }
}

TEST(Playout, JumpsAheadAfterAStallAndOwnsUpToWhatItDidNotDisplay) {
    Playout playout(kTickS);
    for (Tick now = 0; now < 100; ++now) {
        playout.on_update(3);
        playout.advance(now);
    }
    playout.advance(300);
    EXPECT_DOUBLE_EQ(playout.position(), 297.0 - kLead);
    EXPECT_FALSE(playout.shown_at(200).has_value());
    EXPECT_EQ(playout.shown_at(297 - kLead), 300);
    EXPECT_FALSE(playout.shown_at(298 - kLead).has_value());
}

TEST(Playout, RemembersAtWhichViewTickEachTickWasDisplayed) {
    Playout playout(kTickS);
    for (Tick now = 0; now < 1000; ++now) {
        playout.on_update(now < 500 ? 2 : 9);
        playout.advance(now);
    }
    for (Tick tick = 850; tick < 980; ++tick) {
        const auto at = playout.shown_at(tick);
        ASSERT_TRUE(at.has_value()) << tick;
        EXPECT_GE(*at - tick, 8 + kLead);
        EXPECT_LE(*at - tick, 10 + kLead);
    }
}

}  // namespace
}  // namespace zoned::view
