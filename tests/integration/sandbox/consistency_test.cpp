#include "server/app/world/world.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <algorithm>

namespace zoned::harness {
namespace {

class Consistency : public GameTest {
  protected:
    /// A network with all usual faults, for ten seconds.
    void be_bad() {
        server.network.loss = 0.05;
        server.network.delay_s = 0.06;
        server.network.jitter_s = 0.02;
        server.network.duplicate = 0.02;
        server.network.reorder = 0.05;
        bots.seconds = 10.0;
    }
};

TEST_F(Consistency, HoldsOnACleanNetwork) {
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.bots_joined, 8u);
    EXPECT_GT(report.audit.samples, 200u);
    EXPECT_EQ(report.converged_bots, 8u);
}

TEST_F(Consistency, HoldsOnABadNetwork) {
    be_bad();
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.packets_lost, 10u);
    EXPECT_GT(report.audit.samples_after_loss, 0u);
    EXPECT_TRUE(report.warnings.empty()) << report.warnings.front();
    EXPECT_EQ(report.events_lost, 0u);
    EXPECT_EQ(report.events_duplicated, 0u);
}

TEST_F(Consistency, OfAnInterpolatingViewHoldsWithTheBareBound) {
    bots.view = view::ViewKind::kInterpolate;
    server.network.delay_s = 0.06;
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.converged_bots, 8u);
    EXPECT_GT(report.audit.samples, 200u);
    // Nothing is granted for the age of updates, once clock and playout have settled.
    EXPECT_EQ(report.audit.update_age_s.percentile(0.8), 0.0);
    EXPECT_GE(report.view_delay_ticks.percentile(0.5), 2.0);
    EXPECT_LE(report.view_delay_ticks.max(), 8.0);
}

TEST_F(Consistency, OfAnInterpolatingViewHoldsOnABadNetwork) {
    bots.view = view::ViewKind::kInterpolate;
    be_bad();
    server.network.jitter_s = 0.05;
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.samples_after_loss, 0u);
}

TEST_F(Consistency, HoldsForEachKindOfPrediction) {
    for (const char* kind : {"STATIC", "LINEAR", "QUADRATIC", "BALLISTIC", "TURNING"}) {
        server.sets = {std::string("replication.predictor=") + kind};
        bots.seconds = 3.0;
        const measure::RunReport report = run();
        EXPECT_TRUE(report.consistent) << kind << ": " << reasons(report);
    }
}

TEST_F(Consistency, HoldsWithRecordsCodedForEachClientInFewerBytes) {
    be_bad();
    const measure::RunReport shared = run();
    server.sets = {"replication.codec=PER_CLIENT"};
    const measure::RunReport coded = run();
    EXPECT_TRUE(coded.consistent) << reasons(coded);
    EXPECT_EQ(coded.converged_bots, 8u);
    EXPECT_GT(coded.audit.samples_after_loss, 0u);
    EXPECT_EQ(coded.malformed_records, 0u);
    EXPECT_EQ(coded.view_resets, 0u);
    // Most packets hold a record or two among headers and own states; the gain appears in crowds.
    EXPECT_LT(coded.down_bytes_per_s.percentile(0.5), shared.down_bytes_per_s.percentile(0.5));
}

TEST_F(Consistency, WithCodedRecordsOutlastsOutagesAndBorders) {
    server.sets = {"replication.codec=PER_CLIENT"};
    server.network.loss = 0.2;
    server.network.delay_s = 0.05;
    server.network.jitter_s = 0.033;
    server.network.outage_every_s = 3.0;
    server.network.outage_length_s = 0.25;
    bots.mix = bot::parse_mix("border:1,wander:1").value();
    bots.seconds = 12.0;
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.malformed_records, 0u);
}

/// Players stand in each other's sight for some ticks: between two records of the audit one may go
/// and come back, or come and go. Radii have a hysteresis against that, sight has none.
TEST_F(Consistency, HoldsWherePlayersHideBehindEachOther) {
    server.config = ZONED_SOURCE_DIR "/config/hamlet.txtpb";
    server.sets = {"type[0].visibility_filter=LINE_OF_SIGHT"};
    bots.bots = 16;
    bots.seconds = 20.0;
    std::uint64_t gone = 0;
    const measure::RunReport report = run([&](VirtualServer& now, double) {
        for (const auto& zone : now.world().zones()) {
            for (const zone::ViewerFilter& viewer : zone->state().filtered.viewers) {
                gone += static_cast<std::uint64_t>(std::count_if(
                    viewer.seen.begin(), viewer.seen.end(), [](const zone::FilteredPair& pair) {
                        return pair.since < 0 && pair.known >= 0;
                    }));
            }
        }
    });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(gone, 1000U) << "pairs x ticks out of sight";
}

TEST_F(Consistency, HoldsWhenClientClocksAreOff) {
    server.skew_s = 12345.678;
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
}

TEST_F(Consistency, DeliversEventsExactlyOnceWhenStreamsAreCut) {
    bots.bots = 6;
    bots.seconds = 8.0;
    bots.mix = bot::parse_mix("chat:1,fight:1").value();
    double next_cut = 2.0;
    const measure::RunReport report = run([&](VirtualServer& server_now, double now_s) {
        if (now_s >= next_cut && now_s < 7.0) {
            server_now.cut_streams();
            next_cut += 1.5;
        }
    });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GE(report.resumed, 12u);
    EXPECT_EQ(report.events_lost, 0u);
    EXPECT_EQ(report.events_duplicated, 0u);
    EXPECT_EQ(report.events_out_of_order, 0u);
    EXPECT_GT(report.events_delivered, 20u);
}

TEST_F(Consistency, GivesTheSameRunTwice) {
    const auto once = [this] {
        const measure::RunReport report = run();
        return std::make_pair(world->world().state_hash(), report.audit.samples);
    };
    server.network.loss = 0.1;
    server.network.delay_s = 0.03;
    bots.seconds = 3.0;
    const auto first = once();
    const auto second = once();
    EXPECT_EQ(first.first, second.first);
    EXPECT_EQ(first.second, second.second);
    EXPECT_GT(first.second, 0u);
}

}  // namespace
}  // namespace zoned::harness
