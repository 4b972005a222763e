// Starved machines: under the server, under the clients.
#include "tests/harness/game_test.h"
#include "shared/core/rng.h"

namespace zoned::harness {
namespace {

class Overload : public GameTest {
  protected:
    /// Stalls of 50 to 400 ms, about one a second.
    static std::vector<Span> stalls(std::uint64_t seed, double from_s, double until_s) {
        core::Rng rng(seed);
        std::vector<Span> spans;
        for (double at = from_s; at < until_s;) {
            at += static_cast<double>(rng.range(0.2F, 1.5F));
            const double length = static_cast<double>(rng.range(0.05F, 0.4F));
            spans.push_back({at, at + length});
            at += length;
        }
        return spans;
    }
};

/// Clocks of clients are set back and forth here, above all while they settle. The age of updates
/// must be measured by the displayed view, not by a clock that was set in between.
TEST_F(Overload, KeepsThePromiseWhileServerAndClientsAreStarved) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        server.network.delay_s = 0.01;
        server.network.jitter_s = 0.01;
        server.network.loss = 0.02;
        server.server_stalls = stalls(seed, 0.1, 8.0);
        server.sets.clear();
        if (seed % 2 == 0) {
            server.sets.emplace_back("replication.predictor=LINEAR");
        }
        client_stalls = stalls(seed + 100, 0.1, 8.0);
        bots.bots = 20;
        bots.ramp_per_s = 15.0;
        bots.seconds = 8.0;
        const measure::RunReport report = run();
        EXPECT_EQ(report.audit.position_violations, 0u) << seed << ": " << reasons(report);
        EXPECT_EQ(report.audit.orientation_violations, 0u) << seed << ": " << reasons(report);
        EXPECT_EQ(report.audit.missing, 0u) << seed << ": " << reasons(report);
        EXPECT_EQ(report.audit.extra, 0u) << seed << ": " << reasons(report);
        EXPECT_EQ(report.bots_joined, 20u);
        EXPECT_GT(report.audit.samples, 1000u);
    }
}

TEST_F(Overload, OfClientsIsSaidInTheVerdict) {
    bots.seconds = 8.0;
    // Once, for a third of a second: comparisons around that moment are lenient.
    client_stalls = {{4.0, 4.35}};
    const measure::RunReport once = run();
    EXPECT_TRUE(once.consistent) << reasons(once);
    ASSERT_EQ(once.warnings.size(), 1u);
    EXPECT_EQ(once.warnings[0].rfind("stale: ", 0), 0u) << once.warnings[0];
    // All the time: the comparison shows no faults.
    client_stalls.clear();
    for (double at = 1.0; at < 9.0; at += 1.0) {
        client_stalls.push_back({at, at + 0.35});
    }
    const measure::RunReport always = run();
    EXPECT_FALSE(always.consistent);
    EXPECT_TRUE(has_reason(always, "stale: ")) << reasons(always);
}

}  // namespace
}  // namespace zoned::harness
