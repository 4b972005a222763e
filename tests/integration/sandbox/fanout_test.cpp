// Many clients that come or go at once, and the events that each hears of the others.
#include "server/session/host/session_host.h"
#include "tests/harness/game_test.h"

namespace zoned::harness {
namespace {

class FanOut : public GameTest {};

TEST_F(FanOut, TellsThoseWhoLeaveTogetherNothingOfEachOther) {
    bots.bots = 40;
    bots.ramp_per_s = 100.0;
    bots.seconds = 2.0;
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    for (int step = 0; step < 100; ++step) {
        world->step();
    }
    EXPECT_EQ(world->host().stats().sessions, 0u);
    // Nothing is made for a session that is gone: no event, no state.
    const auto rejected = world->host().stats().rejected;
    EXPECT_FALSE(rejected.contains("out_no_session")) << rejected.at("out_no_session");
}

TEST_F(FanOut, TellsThoseWhoStayOfAllWhoLeft) {
    bots.bots = 40;
    bots.ramp_per_s = 1000.0;
    bots.seconds = 4.0;
    bool left = false;
    const measure::RunReport report = run([&](VirtualServer& server_now, double now_s) {
        if (!left && now_s > 2.0) {
            left = true;
            for (std::size_t i = 0; i < 20; ++i) {
                swarm->bots()[i]->quit(server_now.client_time_s());
            }
        }
    });
    // The verdict counts clients that left as lost sessions, but no event as lost.
    EXPECT_EQ(report.bots_lost, 20u);
    EXPECT_EQ(report.events_lost, 0u);
    EXPECT_EQ(report.events_unheard, 0u);
    // Every client hears of its own arrival and of all later ones (40 * 41 / 2) and enters a zone
    // (40); those that stay hear of each that left.
    EXPECT_GE(report.events_delivered, 820u + 40u + 20u * 20u);
}

}  // namespace
}  // namespace zoned::harness
