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

// A test that plays itself: two players go where it sends them, and time goes on where it waits.
TEST_F(GameTest, TagsWhoComesNear) {
    constexpr std::uint32_t kTagged = 100;  // of game.cpp
    server.config = "world.txtpb";
    bots.bots = 2;
    auto& ann = steer();
    auto& bob = steer();
    begin();
    ann.walk_to(-8.0, 0.0);
    bob.walk_to(8.0, 0.0);
    ASSERT_TRUE(play_until([&] { return ann.arrived() && bob.arrived(); }, 20.0));
    const auto tags = bob.heard(kTagged);
    play(3.0);
    EXPECT_EQ(bob.heard(kTagged), tags) << "tagged from afar";
    ann.walk_to(8.0, 0.0);
    EXPECT_TRUE(play_until([&] { return bob.heard(kTagged) > tags; }, 20.0));
    EXPECT_TRUE(finish().consistent);
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
