// Starved machines: under the server, under the clients.
#include "server/app/world/world.h"
#include "tests/harness/game_test.h"
#include "shared/core/rng.h"

namespace zoned::harness {
namespace {

class Overload : public GameTest {
  protected:
    struct Sums {
        std::uint64_t sent = 0;
        std::uint64_t resent = 0;
        std::uint64_t inputs = 0;
        std::uint64_t inputs_missing = 0;
    };

    /// Sums over the zones' reports of each tick, from a moment on.
    class Counter {
      public:
        void look(VirtualServer& whole) {
            if (whole.world().now() == tick_) {
                return;
            }
            tick_ = whole.world().now();
            for (const auto& zone : whole.world().zones()) {
                const replication::ReplicationReport& r = zone->report().replication;
                sums.sent += r.records_sent;
                sums.resent += r.records_resent;
                sums.inputs += r.inputs;
                sums.inputs_missing += r.inputs_missing;
            }
        }

        Sums sums;

      private:
        Tick tick_ = -1;
    };

    /// Runs and counts between two moments of the virtual time.
    Sums count_between(double from_s, double until_s, measure::RunReport& report) {
        Counter counter;
        report = run([&](VirtualServer& whole, double now_s) {
            if (now_s >= from_s && now_s < until_s) {
                counter.look(whole);
            }
        });
        return counter.sums;
    }

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

/// Clients that are short of CPU acknowledge late. Nothing is lost, so next to nothing is sent
/// again.
TEST_F(Overload, MakesLateAcknowledgementsAndNoResends) {
    server.network.delay_s = 0.02;
    bots.bots = 12;
    bots.seconds = 20.0;
    bots.audit = false;
    for (double at = 2.0; at < 20.0; at += 0.5) {
        client_stalls.push_back({at, at + 0.3});
    }
    measure::RunReport report;
    // Until then the path of a new client is taken for a poor one, which calls for copies.
    const Sums sums = count_between(8.0, 20.0, report);
    EXPECT_EQ(report.packets_lost, 0U);
    ASSERT_GT(sums.sent, 2000U);
    EXPECT_LT(sums.resent, sums.sent / 20);
}

TEST_F(Overload, LeavesNothingBehindTwoSecondsAfterAStallOfAnyLength) {
    for (const double length_s : {1.0, 3.0, 6.0}) {
        for (const bool of_server : {false, true}) {
            server.network.delay_s = 0.02;
            server.server_stalls.clear();
            client_stalls.clear();
            (of_server ? server.server_stalls : client_stalls).push_back({4.0, 4.0 + length_s});
            bots.bots = 12;
            bots.seconds = 10.0 + length_s;
            const double calm_s = 4.0 + length_s + 2.0;
            measure::RunReport report;
            const Sums after = count_between(calm_s, calm_s + 2.0, report);
            const char* whose = of_server ? " s of the server" : " s of the clients";
            ASSERT_GT(after.sent, 100U) << length_s << whose;
            EXPECT_EQ(after.resent, 0U) << length_s << whose;
            EXPECT_LT(after.inputs_missing, after.inputs / 100) << length_s << whose;
            EXPECT_EQ(report.audit.position_violations, 0U) << reasons(report);
            EXPECT_EQ(report.audit.missing, 0U) << reasons(report);
        }
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
