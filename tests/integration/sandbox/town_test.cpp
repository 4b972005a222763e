// The world `town` with bots: most of its people are off-screen, and the bots' views are right.
#include "server/app/world/world.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <algorithm>

namespace zoned::harness {
namespace {

/// Observations of the agents.
struct Watch {
    std::uint64_t ticks = 0;
    std::uint64_t active = 0;
    std::uint64_t suspended = 0;
    std::uint64_t events = 0;
    std::uint32_t trades = 0;
    std::uint64_t woken = 0;  ///< from one tick to the next

    void look(app::World& world) {
        ++ticks;
        for (const auto& zone : world.zones()) {
            const zone::ZoneState& state = zone->state();
            const ai::AiReport& report = zone->report().ai;
            active += report.active;
            suspended += report.agents - report.active;
            events += report.events;
            trades += report.trades;
            woken += state.ai_update.resumed().size();
        }
    }
};

TEST_F(GameTest, ATownOfWhichMostIsOffscreenIsConsistent) {
    server.config = ZONED_SOURCE_DIR "/config/town.txtpb";
    // A tenth of the people, and the day begins when fishers set out.
    server.sets = {"ai.dawn_s=35"};
    const int counts[] = {300, 300, 60, 200, 40, 20, 10, 30, 60};
    for (std::size_t k = 0; k < std::size(counts); ++k) {
        server.sets.push_back("scatter[" + std::to_string(k) +
                              "].count=" + std::to_string(counts[k]));
    }
    server.network.delay_s = 0.03;
    server.network.jitter_s = 0.01;
    bots.bots = 12;
    bots.seconds = 30.0;
    Watch watch;
    const measure::RunReport report =
        run([&](VirtualServer& now, double) { watch.look(now.world()); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(watch.suspended, watch.active) << "most are not simulated";
    EXPECT_GT(watch.woken, 20U) << "bots came where nobody was before";
    EXPECT_GT(watch.events, 100U);
}

}  // namespace
}  // namespace zoned::harness
