#include "tests/harness/game_test.h"

namespace zoned::harness {
namespace {

class Solids : public GameTest {
  protected:
    Solids() { server.config = ZONED_SOURCE_DIR "/config/solids.txtpb"; }
};

TEST_F(Solids, AreSeenAsPromisedWhileTheyArePushedAbout) {
    bots.seconds = 8.0;
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(report.audit.samples, 200u);
    EXPECT_EQ(report.converged_bots, 8u);
}

}  // namespace
}  // namespace zoned::harness
