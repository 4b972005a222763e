#include "tests/harness/game_test.h"

namespace zoned::harness {
namespace {

/// The checker is checked: each deliberate fault turns the verdict, for the right reason.
class Faults : public GameTest {
  public:
    measure::RunReport run_with(std::initializer_list<std::string> sets) {
        server.sets.assign(sets);
        return run();
    }
};

/// The state that a view shows, by the kind of view.
class FaultsInView : public Faults, public testing::WithParamInterface<view::ViewKind> {
  protected:
    FaultsInView() { bots.view = GetParam(); }
};

INSTANTIATE_TEST_SUITE_P(Views,
                         FaultsInView,
                         testing::Values(view::ViewKind::kExtrapolate,
                                         view::ViewKind::kInterpolate),
                         [](const auto& instance) {
                             return instance.param == view::ViewKind::kInterpolate
                                        ? "Interpolating"
                                        : "Extrapolating";
                         });

TEST_P(FaultsInView, FindsPositionsThatAreCorrupted) {
    const auto report = run_with(
        {"testing.corrupt_position.probability=0.2", "testing.corrupt_position.offset_m=3"});
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.audit.position_violations, 0u);
    EXPECT_TRUE(has_reason(report, "position")) << reasons(report);
}

TEST_P(FaultsInView, FindsEntitiesThatAreHidden) {
    const auto report = run_with({"testing.hide_entity.probability=0.3"});
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.audit.missing, 0u);
    EXPECT_TRUE(has_reason(report, "missing")) << reasons(report);
}

TEST_P(FaultsInView, FindsEntitiesThatAreLeaked) {
    // Radii of 15 m, so that something lies beyond them.
    const auto report =
        run_with({"type[0].nimbus_m.normal=15", "testing.leak_entity.probability=1"});
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.audit.extra, 0u);
    EXPECT_TRUE(has_reason(report, "leak")) << reasons(report);
}

TEST_F(Faults, FindsEventsThatAreDropped) {
    const auto report = run_with({"testing.drop_event.probability=0.2"});
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.events_lost + report.events_unheard, 0u);
    EXPECT_TRUE(has_reason(report, "event")) << reasons(report);
}

TEST_F(Faults, FindsEventsThatAreDoubled) {
    const auto report = run_with({"testing.double_event.probability=0.2"});
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.events_duplicated, 0u);
    EXPECT_TRUE(has_reason(report, "twice")) << reasons(report);
}

TEST_F(Faults, FindsAZoneThatStalls) {
    const auto report = run_with({"testing.stall_zone.at_tick=90", "testing.stall_zone.ticks=60"});
    EXPECT_FALSE(report.consistent);
    EXPECT_TRUE(has_reason(report, "silen") || has_reason(report, "stall")) << reasons(report);
}

TEST_F(Faults, FindsLimitsThatTheWorldDoesNotKeep) {
    server.network.delay_s = 0.1;
    const auto report = run_with({"testing.wrong_limit.max_acceleration_mps2=0.1",
                                  "testing.wrong_limit.max_velocity_jump_mps=0"});
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.audit.position_violations, 0u);
}

TEST_P(FaultsInView, FindsLostUpdatesThatAreNotSentAgain) {
    server.network.delay_s = 0.03;
    server.network.loss = 0.2;
    EXPECT_TRUE(run_with({}).consistent);
    const auto report = run_with({"testing.never_again=true"});
    EXPECT_FALSE(report.consistent);
    EXPECT_GT(report.audit.position_violations + report.audit.missing + report.audit.extra, 0u)
        << reasons(report);
}

/// A budget that leaves out some excuses no others.
TEST_P(FaultsInView, FindsEntitiesThatAreHiddenUnderPressure) {
    const auto honest = run_with({"scatter[1].count=400", "replication.budget_bytes_per_s=2000"});
    EXPECT_EQ(honest.audit.missing, 0u) << reasons(honest);
    EXPECT_EQ(honest.audit.position_violations, 0u) << reasons(honest);
    EXPECT_GT(honest.audit.missing_notified, 0u);
    server.sets.emplace_back("testing.hide_entity.probability=0.3");
    EXPECT_GT(run().audit.missing, 0u);
}

TEST_P(FaultsInView, FindsNoneWithoutAny) {
    const auto report = run_with({});
    EXPECT_TRUE(report.consistent) << reasons(report);
}

}  // namespace
}  // namespace zoned::harness
