// Time of day and weather, run by every client for itself.
#include "tests/harness/game_test.h"

namespace zoned::harness {
namespace {

class SlowState : public GameTest {
  protected:
    SlowState() {
        server.sets = {"slow.clock[0].name=time_of_day",
                       "slow.clock[0].start=23.99",
                       "slow.clock[0].rate_per_s=0.02",
                       "slow.clock[0].period=24",
                       "slow.variable[0].name=rain",
                       "slow.variable[0].blend_s=2",
                       "slow.variable[0].phase[0].name=clear",
                       "slow.variable[0].phase[0].min_s=1",
                       "slow.variable[0].phase[0].max_s=3",
                       "slow.variable[0].phase[1].name=storm",
                       "slow.variable[0].phase[1].value=1",
                       "slow.variable[0].phase[1].min_s=1",
                       "slow.variable[0].phase[1].max_s=2"};
        bots.audit_every_s = 0.3;
    }

    [[nodiscard]] std::uint64_t slow_told() const {
        std::uint64_t told = 0;
        for (const auto& bot : swarm->bots()) {
            told += bot->view() != nullptr ? bot->view()->stats().slow_told : 0;
        }
        return told;
    }
};

TEST_F(SlowState, IsTheSameToTheLastBitForEveryTickThatIsDisplayed) {
    server.network.loss = 0.05;
    server.network.delay_s = 0.06;
    bots.seconds = 12.0;
    const measure::Report report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.slow_samples, 200U);
    EXPECT_EQ(report.audit.slow_violations, 0U);
    EXPECT_EQ(report.slow_corrected, 0U);
    // Told at login and no more: the next time is after a minute.
    EXPECT_EQ(slow_told(), bots.bots);
}

TEST_F(SlowState, IsSynchronisedNowAndThenAndNeedsNoCorrection) {
    server.sets.emplace_back("slow.sync_every_s=2");
    bots.seconds = 10.0;
    const measure::Report report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GE(slow_told(), bots.bots * 5U);
    EXPECT_EQ(report.slow_corrected, 0U);
}

TEST_F(SlowState, OfAClientThatWasToldAWrongRateIsFoundByTheAudit) {
    server.sets.emplace_back("testing.wrong_clock=0.01");
    const measure::Report report = run();
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.audit.slow_violations, 0U);
    EXPECT_TRUE(has_reason(report, "slow state")) << reasons(report);
}

}  // namespace
}  // namespace zoned::harness
