// Server, bots and a bad network in one process, on virtual time. ZONED_SEED=n gives networks and
// bots another course: a claim that holds for one seed has to hold for all.
#include "tests/harness/game_test.h"

#include "bots.h"

#include <sstream>

class CaptureTest : public GameTest {
  protected:
    CaptureTest() {
        server.config = "world.txtpb";
        bots.bots = 10;
        bots.seconds = 180;
        bots.make_own_script = [this](std::size_t index, const std::string& team) {
            if (index == 0) {
                heard = std::make_shared<capture::Heard>();
            }
            return std::make_unique<capture::Bot>(
                index, team, index == 0 ? heard : std::make_shared<capture::Heard>());
        };
    }

    /// All captures on a leaderboard.
    static unsigned captures_on(const std::string& board) {
        std::istringstream lines(board);
        unsigned sum = 0;
        unsigned captures = 0;
        for (std::string name; lines >> captures >> name;) {
            sum += captures;
        }
        return sum;
    }

    std::shared_ptr<capture::Heard> heard;  // by the first bot of the newest run
};

TEST_F(CaptureTest, IsPlayedConsistentlyOnABadNetwork) {
    server.network.loss = 0.05;
    server.network.delay_s = 0.06;
    server.network.jitter_s = 0.02;
    const auto report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.events_lost, 0u);
    EXPECT_GT(heard->taken, 0u);
    EXPECT_GT(heard->dropped, 0u) << "nobody was shoved while it carried a flag";
    EXPECT_GT(heard->scored, 0u);
    EXPECT_EQ(captures_on(heard->leaderboard), heard->scored);
}

TEST_F(CaptureTest, KeepsItsLeaderboardOverARestart) {
    server.records = std::make_shared<zoned::harness::Records>();
    run();
    const std::string before = heard->leaderboard;
    ASSERT_GT(captures_on(before), 0u);
    // Nobody can score in so short a time.
    bots.seconds = 1;
    bots.ramp_per_s = 5;
    run();
    EXPECT_EQ(heard->scored, 0u);
    EXPECT_EQ(heard->leaderboard, before);
}

// The checker is checked: a server that hides an entity from its clients must be found.
TEST_F(CaptureTest, FindsAFaultOnPurpose) {
    bots.seconds = 5;
    server.sets = {"testing.hide_entity.probability=0.1"};
    EXPECT_FALSE(run().consistent);
}

// The same inputs give the same game, or no recording could be replayed and no crash undone.
TEST_F(CaptureTest, IsTheSameEachTimeItIsPlayed) {
    bots.seconds = 20;
    EXPECT_EQ(difference_between_runs(), "");
}
