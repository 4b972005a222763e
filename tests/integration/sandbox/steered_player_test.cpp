// Players that a test steers: they go where they are sent, act, see, and are judged like bots.
#include "tests/harness/game_test.h"
#include "proto/sandbox.pb.h"

namespace {

using zoned::Vec3;
using zoned::Vec3d;
using zoned::harness::SteeredPlayer;

class SteeredPlayers : public GameTest {
  protected:
    SteeredPlayers() { bots.bots = 2; }

    SteeredPlayer& ann = steer();
    SteeredPlayer& bob = steer();

    void send(SteeredPlayer& player, double x, double z) {
        player.walk_to(x, z);
        EXPECT_TRUE(play_until([&] { return player.arrived(); }, 30.0))
            << "still " << player.distance_to(x, z) << " m away";
    }
};

TEST_F(SteeredPlayers, ComeToWhereTheyAreSentAndSeeEachOther) {
    server.network.delay_s = 0.05;
    begin();
    send(ann, 12.0, 5.0);
    send(bob, 9.0, 5.0);
    play(1.0);  // what is displayed is late
    ASSERT_EQ(ann.seen("player").size(), 1U);
    EXPECT_EQ(bob.nearest("player")->id, ann.id());
    EXPECT_LT((bob.nearest("player")->position - ann.position()).norm(), 0.1);
    EXPECT_LE(ann.distance_to(12.0, 5.0), SteeredPlayer::kThereM);
    // They stand.
    const Vec3d before = ann.position();
    play(1.0);
    EXPECT_LT((ann.position() - before).norm(), 0.05);
    EXPECT_TRUE(ann.nearest("crate"));
    EXPECT_FALSE(ann.nearest("no such type"));
    const auto report = finish();
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.bots_joined, 2U);
}

TEST_F(SteeredPlayers, LookAndPressAsTheyAreTold) {
    begin();
    send(ann, 0.0, 3.0);
    ann.look_at(ann.position() + Vec3d(10.0, 0.0, 0.0));
    play(0.5);
    // A yaw of 0 looks along +z: bob sees her face along +x.
    const Vec3 ahead = bob.nearest("player")->orientation * Vec3::UnitZ();
    EXPECT_GT(ahead.x(), 0.99F);
    const double ground = ann.position().y();
    ann.press(zoned::motion::kButtonJump);
    EXPECT_TRUE(play_until([&] { return ann.position().y() > ground + 0.3; }, 1.0));
    EXPECT_TRUE(play_until([&] { return ann.position().y() < ground + 0.01; }, 2.0));
    play(1.0);
    EXPECT_LT(ann.position().y(), ground + 0.01) << "one press is one jump";
    ann.hold(zoned::motion::kButtonJump);
    play(1.2);
    EXPECT_TRUE(play_until([&] { return ann.position().y() > ground + 0.3; }, 1.0));
    ann.hold(0);
    EXPECT_TRUE(finish().consistent);
}

TEST_F(SteeredPlayers, SpeakAndHear) {
    begin();
    zoned::sandbox::Chat chat;
    chat.set_topic("world");
    chat.set_text("good day");
    ann.command(zoned::sandbox::COMMAND_CHAT, chat.SerializeAsString());
    EXPECT_EQ(bob.heard(zoned::sandbox::EVENT_CHAT), 0U) << "before time goes on";
    EXPECT_TRUE(play_until([&] { return bob.heard(zoned::sandbox::EVENT_CHAT) == 1; }, 2.0));
    const auto report = finish();
    EXPECT_TRUE(report.consistent) << reasons(report);
}

TEST_F(SteeredPlayers, PlayBesideBotsAndAreJudgedLikeThem) {
    bots.bots = 6;
    server.sets = {"testing.corrupt_position.probability=0.2"};
    begin();
    send(ann, 10.0, 10.0);
    play(3.0);
    const auto report = finish();
    EXPECT_EQ(report.bots_joined, 6U);
    EXPECT_TRUE(has_reason(report, "bound")) << reasons(report);
}

TEST_F(SteeredPlayers, WaitNoLongerThanTheyMay) {
    begin();
    const double begun_s = world->now_s();
    EXPECT_FALSE(play_until([] { return false; }, 2.0));
    EXPECT_NEAR(world->now_s() - begun_s, 2.0, 0.01);
    // Out of the world: nobody gets there.
    ann.walk_to(1e6, 0.0);
    EXPECT_FALSE(play_until([&] { return ann.arrived(); }, 1.0));
}

}  // namespace
