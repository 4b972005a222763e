// Time of day and weather, run by every client for itself.
#include "tests/harness/game_test.h"

namespace zoned::harness {
namespace {

class SharedEnvironment : public GameTest {
  protected:
    SharedEnvironment() {
        server.sets = {"environment.clock[0].name=time_of_day",
                       "environment.clock[0].start=23.99",
                       "environment.clock[0].rate_per_s=0.02",
                       "environment.clock[0].period=24",
                       "environment.variable[0].name=rain",
                       "environment.variable[0].blend_s=2",
                       "environment.variable[0].phase[0].name=clear",
                       "environment.variable[0].phase[0].min_s=1",
                       "environment.variable[0].phase[0].max_s=3",
                       "environment.variable[0].phase[1].name=storm",
                       "environment.variable[0].phase[1].value=1",
                       "environment.variable[0].phase[1].min_s=1",
                       "environment.variable[0].phase[1].max_s=2"};
        bots.audit_every_s = 0.3;
    }

    [[nodiscard]] std::uint64_t environment_updates() const {
        std::uint64_t told = 0;
        for (const auto& bot : swarm->bots()) {
            told += bot->view() != nullptr ? bot->view()->stats().environment_updates : 0;
        }
        return told;
    }
};

TEST_F(SharedEnvironment, IsTheSameToTheLastBitForEveryTickThatIsDisplayed) {
    server.network.loss = 0.05;
    server.network.delay_s = 0.06;
    bots.seconds = 12.0;
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.environment_samples, 200U);
    EXPECT_EQ(report.audit.environment_violations, 0U);
    EXPECT_EQ(report.environment_corrected, 0U);
    // Sent at login and not again: the next time is after a minute.
    EXPECT_EQ(environment_updates(), bots.bots);
}

TEST_F(SharedEnvironment, IsSynchronisedNowAndThenAndNeedsNoCorrection) {
    server.sets.emplace_back("environment.sync_every_s=2");
    bots.seconds = 10.0;
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GE(environment_updates(), bots.bots * 5U);
    EXPECT_EQ(report.environment_corrected, 0U);
}

TEST_F(SharedEnvironment, OfAClientThatWasToldAWrongRateIsFoundByTheAudit) {
    server.sets.emplace_back("testing.wrong_clock=0.01");
    const measure::RunReport report = run();
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.audit.environment_violations, 0U);
    EXPECT_TRUE(has_reason(report, "shared environment")) << reasons(report);
}

}  // namespace
}  // namespace zoned::harness
