// The world `learned`: a policy trained in a simulated arena plays against bots, inside its guard.
#include "server/app/world/world.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <array>
#include <cmath>

namespace zoned::harness {
namespace {

/// Observations of the hounds, terriers and fighters.
struct Pack {
    float farthest = 0.0F;         ///< from home, m
    std::array<int, 2> hunting{};  ///< hounds and terriers x ticks at some speed
    std::array<int, 2> near{};     ///< of these within 3 m of a player
    float fighter_m = 0.0F;        ///< the farthest fighter from home, m
    int walking_up = 0;            ///< fighters x ticks with a player beyond 6 m whom they approach
    int otherwise = 0;             ///< the same, whom they leave
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
                const Vec3 off = e.position[row] - agent.home;
                const float home_m = std::hypot(off.x(), off.z());
                if (type == "fighter") {
                    look_at_fighter(e, row, agent);
                    fighter_m = std::max(fighter_m, home_m);
                    continue;
                }
                if (type == "pacer") {
                    fastest_band = std::max(fastest_band, agent.band);
                    slowest_band = std::min(slowest_band, agent.band);
                    continue;
                }
                farthest = std::max(farthest, home_m);
                const bool hunts = e.velocity[row].norm() > 1.0F;
                const world::Row prey = agent.prey ? e.find(agent.prey) : world::kNoRow;
                const std::size_t kind = type == "hound" ? 0 : 1;
                hunting[kind] += hunts ? 1 : 0;
                near[kind] += hunts && prey != world::kNoRow &&
                                      (e.position[prey] - e.position[row]).norm() < 3.0F
                                  ? 1
                                  : 0;
            }
        }
    }

    void look_at_fighter(const world::Entities& e, world::Row row, const ai::Agent& agent) {
        const world::Row prey = agent.prey ? e.find(agent.prey) : world::kNoRow;
        if (prey == world::kNoRow || agent.state_machine.leaf != 1) {
            return;
        }
        const Vec3 way = e.position[prey] - e.position[row];
        const float towards = way.dot(e.velocity[row]);
        walking_up += way.norm() > 6.0F && towards > 0.0F ? 1 : 0;
        otherwise += way.norm() > 6.0F && towards < 0.0F ? 1 : 0;
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
    std::printf(
        "hunting %d and %d, near a player %d and %d, fighters approach %d, leave %d, "
        "farthest %.2f m, band %.3f to %.3f\n",
        pack.hunting[0],
        pack.hunting[1],
        pack.near[0],
        pack.near[1],
        pack.walking_up,
        pack.otherwise,
        static_cast<double>(pack.farthest),
        static_cast<double>(pack.slowest_band),
        static_cast<double>(pack.fastest_band));
    // Twelve hounds and three terriers.
    EXPECT_GT(pack.hunting[0], 1000);
    EXPECT_GT(pack.near[0], 100);
    EXPECT_GT(pack.hunting[1], 250);
    EXPECT_GT(pack.near[1], 25);
    // 22 m, and as much as players may push by in passing: half a metre.
    EXPECT_LT(pack.farthest, 22.5F);
    // As the recorded players did; nobody makes it come home but its guard, at 30 m.
    EXPECT_GT(pack.walking_up, 2 * pack.otherwise);
    EXPECT_GT(pack.walking_up, 100);
    EXPECT_LT(pack.fighter_m, 30.5F);
    // Pacers adapt, within their cap.
    EXPECT_LT(pack.slowest_band, 0.95F);
    EXPECT_GE(pack.slowest_band, 0.5F);
    EXPECT_LE(pack.fastest_band, 1.3F);
}

}  // namespace
}  // namespace zoned::harness
