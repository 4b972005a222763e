// The world of cubes: records without velocities, each coded for one client, sixty times a second.
#include "tests/harness/game_test.h"

namespace zoned::harness {
namespace {

class Cubes : public GameTest {
  protected:
    Cubes() {
        server.config = ZONED_SOURCE_DIR "/config/cubes.txtpb";
        bots.bots = 4;
        bots.seconds = 6.0;
    }

    void expect_promise_kept(const measure::RunReport& report) {
        EXPECT_TRUE(report.consistent) << reasons(report);
        EXPECT_GT(report.audit.samples, 1000U);
        EXPECT_EQ(report.converged_bots, 4U);
    }
};

TEST_F(Cubes, AreSeenToHalfAStepWhileGiantsPushThemAbout) {
    expect_promise_kept(run());
}

TEST_F(Cubes, AreSeenAsPromisedOverABadNetwork) {
    server.network.loss = 0.05;
    server.network.delay_s = 0.06;
    server.network.jitter_s = 0.02;
    expect_promise_kept(run());
}

TEST_F(Cubes, ThatAreTwoCentimetresOffAreFound) {
    server.sets = {"testing.corrupt_position.probability=0.05",
                   "testing.corrupt_position.offset_m=0.02"};
    const measure::RunReport report = run();
    EXPECT_FALSE(report.consistent);
    EXPECT_TRUE(has_reason(report, "position")) << reasons(report);
}

}  // namespace
}  // namespace zoned::harness
