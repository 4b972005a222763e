// Server, bots and a bad network in one process, on virtual time. ZONED_SEED=n gives networks and
// bots another course: a claim that holds for one seed has to hold for all.
#include "tests/harness/game_test.h"

TEST_F(GameTest, StaysConsistentOnABadNetwork) {
    server.config = "world.txtpb";
    server.network.loss = 0.05;
    server.network.delay_s = 0.06;
    server.network.jitter_s = 0.02;
    bots.bots = 20;
    bots.seconds = 10;
    bots.mix = *zoned::bot::parse_mix("crowd");  // who stand together tag each other
    const auto report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.events_lost, 0u);
    EXPECT_GT(report.events_delivered, 100u) << "nobody was tagged";
}

// The checker is checked: a server that hides an entity from its clients must be found.
TEST_F(GameTest, FindsAFaultOnPurpose) {
    server.config = "world.txtpb";
    server.sets = {"testing.hide_entity.probability=0.1"};
    EXPECT_FALSE(run().consistent);
}

// The same inputs give the same game, or no recording could be replayed and no crash undone. A
// clock, a file, a random number of one's own or a socket in the rules is named here, with the call
// that used it. An unordered map shows by the tick.
TEST_F(GameTest, IsTheSameEachTimeItIsPlayed) {
    server.config = "world.txtpb";
    bots.mix = *zoned::bot::parse_mix("crowd");
    EXPECT_EQ(difference_between_runs(), "");
}
