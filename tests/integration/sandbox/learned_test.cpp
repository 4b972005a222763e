// The world `learned`: a policy trained in a simulated arena plays against bots, inside its guard.
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <cmath>

namespace zoned::harness {
namespace {

/// Observations of the hounds.
struct Pack {
    float farthest = 0.0F;  ///< from home, m
    int hunting = 0;        ///< hounds x ticks at some speed
    int near = 0;           ///< of these within 3 m of a player
    float fastest_band = 1.0F;
    float slowest_band = 1.0F;

    void look(app::World& world) {
        for (const auto& zone : world.zones()) {
            zone::ZoneState& state = zone->state();
            const world::Entities& e = state.entities;
            for (std::size_t n = 0; n < state.agents.size(); ++n) {
                const ai::Agent& agent = state.agents.at(state.agents.nth(n));
                const world::Row row = e.find(agent.entity);
                const std::string& type = (*state.settings.types)[e.type[row]].name;
                if (type != "hound") {
                    fastest_band = std::max(fastest_band, agent.band);
                    slowest_band = std::min(slowest_band, agent.band);
                    continue;
                }
                const Vec3 off = e.position[row] - agent.home;
                farthest = std::max(farthest, std::hypot(off.x(), off.z()));
                const bool hunts = e.velocity[row].norm() > 1.0F;
                const world::Row prey = agent.prey ? e.find(agent.prey) : world::kNoRow;
                hunting += hunts ? 1 : 0;
                near += hunts && prey != world::kNoRow &&
                                (e.position[prey] - e.position[row]).norm() < 3.0F
                            ? 1
                            : 0;
            }
        }
    }
};

TEST_F(GameTest, HoundsHuntAsTrainedAndNeverLeaveTheirGuard) {
    server.config = ZONED_SOURCE_DIR "/config/learned.txtpb";
    server.network.delay_s = 0.03;
    bots.bots = 10;
    bots.seconds = 20.0;
    Pack pack;
    const measure::RunReport report =
        run([&](VirtualServer& now, double) { pack.look(now.world()); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    std::printf("hunting %d, near a player %d, farthest %.2f m, band %.3f to %.3f\n",
                pack.hunting,
                pack.near,
                static_cast<double>(pack.farthest),
                static_cast<double>(pack.slowest_band),
                static_cast<double>(pack.fastest_band));
    EXPECT_GT(pack.hunting, 1000);
    EXPECT_GT(pack.near, 100);
    // 22 m, and as much as players may push by in passing: half a metre.
    EXPECT_LT(pack.farthest, 22.5F);
    // Pacers adapt, within their cap.
    EXPECT_LT(pack.slowest_band, 0.95F);
    EXPECT_GE(pack.slowest_band, 0.5F);
    EXPECT_LE(pack.fastest_band, 1.3F);
}

}  // namespace
}  // namespace zoned::harness
