#include "tests/harness/game_test.h"

#include <string>
#include <vector>

namespace zoned::harness {
namespace {

/// A crowd and a budget that does not suffice for it.
class Pressure : public GameTest {
  protected:
    Pressure() {
        server.sets = {"replication.codec=SHARED",
                       "scatter[1].count=60",
                       "brain[0].state[0].transition[0].threshold=100000",
                       "replication.budget_bytes_per_s=2000"};
        server.network.delay_s = 0.04;
        bots.bots = 4;
        bots.seconds = 10.0;
    }
};

TEST_F(Pressure, WidensTheBoundsAndSaysSo) {
    const auto report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.samples_widened, report.audit.samples / 4);
    EXPECT_EQ(report.audit.position_violations, 0u);
    // A bound is named for nearly all of them.
    EXPECT_LT(report.audit.samples_unbounded, report.audit.samples / 20);
}

/// A client that is to wait for its next packet would go on believing in narrower bounds until
/// then. Whether an entity turns just then is chance: six courses.
TEST_F(Pressure, SaysAtOnceThatBoundsAreWider) {
    for (const std::uint64_t seed : {5U, 7U, 15U, 28U, 30U, 34U}) {
        bots.seed = seed;
        server.network.seed = seed;
        const auto report = run();
        EXPECT_TRUE(report.consistent) << seed << ": " << reasons(report);
    }
}

TEST_F(Pressure, IsRelievedByCodingForWhoseDownlinkIsShort) {
    // Enough for about two thirds of the time: of less, headers take most, which no codec makes
    // smaller.
    server.sets.back() = "replication.budget_bytes_per_s=2500";
    const auto share = [](const measure::RunReport& r) {
        return static_cast<double>(r.audit.samples_widened) / static_cast<double>(r.audit.samples);
    };
    // Where the crowd walks decides too: several worlds, of which the mean counts.
    constexpr int kWorlds = 6;
    double shared = 0.0;
    double chosen = 0.0;
    for (int seed = 1; seed <= kWorlds; ++seed) {
        const std::vector<std::string> sets = server.sets;
        server.sets.push_back("world.seed=" + std::to_string(seed));
        const double plain = share(run());
        server.sets.front() = "replication.codec=AUTO";
        const auto coded = run();
        EXPECT_TRUE(coded.consistent) << reasons(coded);
        EXPECT_EQ(coded.malformed_records, 0u);
        EXPECT_EQ(coded.view_resets, 0u);
        EXPECT_LT(share(coded), plain) << seed;
        shared += plain / kWorlds;
        chosen += share(coded) / kWorlds;
        server.sets = sets;
    }
    EXPECT_LT(chosen, 0.8 * shared);
}

TEST_F(Pressure, IsFoundWhereTheServerIsSilentlyLate) {
    server.sets.emplace_back("testing.silent_bound=true");
    const auto report = run();
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.audit.position_violations, 0u);
    EXPECT_TRUE(has_reason(report, "bound")) << reasons(report);
}

TEST_F(Pressure, LeavesThePromiseAloneWhereTheBudgetSuffices) {
    server.sets.back() = "replication.budget_bytes_per_s=60000";
    const auto report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.audit.samples_widened, 0u);
    EXPECT_EQ(report.audit.samples_unbounded, 0u);
}

}  // namespace
}  // namespace zoned::harness
