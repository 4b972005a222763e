// Paths through several zones: an agent bound beyond its own zone is led past dead ends there.
#include "server/ai/steering/path_following.h"
#include "tests/integration/plain/crowd_world.h"

#include <optional>

namespace zoned::app::test {
namespace {

/// Four zones of 30 m. The walker is in the north-west and wants to go to the north-east. The
/// border between the two is open for 30 m. Behind it is a pocket that nothing leads out of: walls
/// at x = 5 and, from x = -10 on, at z = 4. Past them the path leads through both zones in the
/// south.
std::string pocket_world(const std::string& ai) {
    return R"(
world { name: "pocket" seed: 3 tick_rate_hz: 30 min_x_m: -30 min_z_m: -30 max_x_m: 30 max_z_m: 30 }
zones { zone_grid { columns: 2 rows: 2 } ghost_margin_m: 25 handoff_hysteresis_m: 1 }
ai { pathfinding { } )" +
           ai + R"( }
statics {
  box { x_m: 5 y_m: 1 z_m: -15 size { x_m: 0.5 y_m: 2 z_m: 38.5 } }
  box { x_m: -2.5 y_m: 1 z_m: 4 size { x_m: 15.5 y_m: 2 z_m: 0.5 } }
}
point_of_interest { name: "east" x_m: 20 z_m: -20 radius_m: 0.5 }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 20 } nimbus_m { normal: 20 } character { speed_mps: 3 } }
type { name: "walker" base: "player" brain: "walker" character { speed_mps: 3 } }
brain {
  name: "walker"
  state { name: "go" action: GO point_of_interest: "east" transition { to: "stay" sense: "east.distance" compare: BELOW threshold: 2 } }
  state { name: "stay" action: IDLE }
}
spawn { x_m: 20 z_m: 20 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)";
}

struct Walk {
    std::optional<Tick> arrived;  ///< within 2 m of its spot, which is within 0.5 m of the place
    std::vector<ZoneId> through;  ///< owners, one after the other
    std::uint32_t suspended_ticks = 0;  ///< in which the agent was not simulated
};

Walk walk(const std::string& text) {
    Crowd crowd(text, {{"walker", {-20.0F, -20.0F}}});
    Walk walk;
    for (Tick tick = 1; tick <= 3000 && !walk.arrived; ++tick) {
        crowd.tick();
        for (const auto& zone : crowd.world().zones()) {
            const zone::ZoneState& state = zone->state();
            const world::Entities& e = state.entities;
            for (world::Row row = 0; row < e.size(); ++row) {
                if (e.has(row, world::kGhost)) {
                    continue;
                }
                if (walk.through.empty() || walk.through.back() != state.settings.id) {
                    walk.through.push_back(state.settings.id);
                }
                const ai::Agent* agent = state.agents.find(e.id[row]);
                const Vec2d origin(state.settings.region().origin().x(),
                                   state.settings.region().origin().z());
                const Vec2 local = ai::whereabouts(*agent,
                                                   Vec2(e.position[row].x(), e.position[row].z()),
                                                   state.now,
                                                   state.settings.dt);
                walk.suspended_ticks += agent->tier == ai::Tier::kSuspended ? 1U : 0U;
                if ((origin + local.cast<double>() - Vec2d(20.0, -20.0)).norm() <= 2.5) {
                    walk.arrived = tick;
                }
            }
        }
    }
    return walk;
}

const std::vector<ZoneId> kRoundThePocket{ZoneId(1), ZoneId(3), ZoneId(4), ZoneId(2)};

TEST(PathsBetweenZones, LeadPastADeadEndThroughThreeBorders) {
    const Walk seen = walk(pocket_world("suspend_offscreen: false"));
    ASSERT_TRUE(seen.arrived);
    EXPECT_EQ(seen.through, kRoundThePocket);
    EXPECT_EQ(seen.suspended_ticks, 0U);
    // The best path round both ends of the walls is 26.4 + 16.4 + 28.5 m long, less the last 2.5 m.
    // Portals are up to 12 m apart, which adds half of that at most at each of the three borders.
    // The walker moves at 0.98 of 3 m/s and loses a second at each turn.
    EXPECT_GE(*seen.arrived, static_cast<Tick>(68.8 / 3.0 * 30.0) - 30);
    EXPECT_LE(*seen.arrived, static_cast<Tick>((68.8 + 3.0 * 6.0) / 2.94 * 30.0) + 3 * 30);
}

TEST(PathsBetweenZones, AreWalkedInTheSameTimeWhereNobodySeesThem) {
    const Walk seen = walk(pocket_world("suspend_offscreen: false"));
    const Walk unseen = walk(pocket_world("suspend_offscreen: true"));
    ASSERT_TRUE(unseen.arrived);
    EXPECT_GT(unseen.suspended_ticks, 60U);
    EXPECT_EQ(unseen.through, kRoundThePocket);
    EXPECT_EQ(*unseen.arrived, *seen.arrived);
}

TEST(PathsBetweenZones, AreAsLongWithinOne) {
    const std::string text =
        with(pocket_world("suspend_offscreen: false"), "columns: 2 rows: 2", "columns: 1 rows: 1");
    const Walk seen = walk(text);
    ASSERT_TRUE(seen.arrived);
    EXPECT_GE(*seen.arrived, static_cast<Tick>(68.8 / 3.0 * 30.0) - 30);
    EXPECT_LE(*seen.arrived, static_cast<Tick>(68.8 / 2.94 * 30.0) + 3 * 30);
}

}  // namespace
}  // namespace zoned::app::test
