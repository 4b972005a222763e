// A player that is polled as a game or a page does it: once for each picture.
#include "client-sim/view/player.h"

#include "tests/unit/client/fake_server.h"

#include <gtest/gtest.h>

namespace zoned::test {
namespace {

class Listener final : public view::PlayerListener {
  public:
    motion::InputCommand command_for(Tick tick) override {
        motion::InputCommand command;
        command.tick = tick;
        command.move_x = 100;
        return command;
    }
};

class PolledPlayer : public ::testing::Test {
  protected:
    /// Runs for so long; the player is polled so often.
    void run(double seconds, double picture_s) {
        if (!player) {
            server.avatar.emplace();
            server.avatar->grounded = true;
            server.avatar->position = Vec3(0.0F, 0.9F, 0.0F);
            player.emplace(server, worlds, listener, view::PlayerSettings{});
            player->start(now);
        }
        const double end = now + seconds;
        while (now < end) {
            now += 0.001;
            server.advance(now);
            if (now >= picture_at) {
                picture_at += picture_s;
                player->advance(now);
            }
        }
    }

    FakeServer server;
    view::WorldCache worlds;
    Listener listener;
    std::optional<view::Player> player;
    double now = 0.0;
    double picture_at = 0.0;
};

/// A picture comes up to 17 ms after a command was due: the lead covers that from when it has
/// measured its first packets.
TEST_F(PolledPlayer, AtSixtyPicturesASecondMakesItsCommandsInTime) {
    run(1.5, 1.0 / 59.0);
    const std::uint64_t before = player->inputs().stats().missing;
    run(10.0, 1.0 / 59.0);
    EXPECT_GT(player->inputs().stats().ticks, 300U);
    EXPECT_LE(player->inputs().stats().missing - before, 2U);
    EXPECT_LT(player->inputs().lead_s(), 0.030);
}

TEST_F(PolledPlayer, OverAWebSocketSendsAllInsideItFromTheFirstOn) {
    server.websocket = true;
    run(3.0, 1.0 / 60.0);
    EXPECT_TRUE(player->ready());
    EXPECT_GT(server.input_packets, 60);
    EXPECT_EQ(server.tunnelled_packets, server.input_packets);
    EXPECT_TRUE(player->client().stats().websocket);
    EXPECT_EQ(player->client().datagrams().unauthenticated, 0U);
    EXPECT_EQ(player->client().datagrams().malformed, 0U);
    // A stream that was cut is opened again, and may be of the other kind.
    server.websocket = false;
    server.cut();
    run(3.0, 1.0 / 60.0);
    EXPECT_EQ(player->client().stats().resumed, 1U);
    EXPECT_GT(server.input_packets, server.tunnelled_packets + 30);
    EXPECT_FALSE(player->client().stats().websocket);
}

}  // namespace
}  // namespace zoned::test
