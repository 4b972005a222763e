// Crowding: paths lead around crowds, in a zone.
#include "tests/integration/plain/crowd_world.h"

#include <array>

namespace zoned::app {
namespace {

using test::Crowd;
using test::with;

/// A wall with two gates of 4 m: one straight ahead, one 12 m to the side. All agents are on one
/// side and want to be at a place on the other.
const char* const kGates = R"(
world { name: "gates" seed: 9 tick_rate_hz: 30 min_x_m: -40 min_z_m: -30 max_x_m: 40 max_z_m: 30 }
zones { zone_grid { columns: 1 rows: 1 } ghost_margin_m: 70 }
ai { suspend_offscreen: false avoidance { } pathfinding { cell_m: 0.5 CROWDING } }
statics {
  box { x_m: 0 y_m: 1 z_m: -16 size { x_m: 0.5 y_m: 2 z_m: 28 } }
  box { x_m: 0 y_m: 1 z_m: 6 size { x_m: 0.5 y_m: 2 z_m: 8 } }
  box { x_m: 0 y_m: 1 z_m: 22 size { x_m: 0.5 y_m: 2 z_m: 16 } }
}
point_of_interest { name: "there" x_m: 26 z_m: 0 radius_m: 12 }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 30 } nimbus_m { normal: 30 } character { speed_mps: 3 } }
type { name: "walker" base: "player" brain: "walk" }
brain { name: "walk" state { name: "go" action: GO point_of_interest: "there" } }
spawn { x_m: -38 z_m: -28 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)";

TEST(Crowding, IsTheSameForAnyNumberOfThreads) {
    std::array<std::uint64_t, 2> hash{};
    for (const unsigned threads : {1U, 4U}) {
        Crowd crowd(
            with(with(kGates, "CROWDING", "crowding { jam_per_m2: 1.6 }"),
                 "spawn {",
                 "scatter { type: \"walker\" count: 200 seed: 5 region { min_x_m: -30 "
                 "min_z_m: -20 max_x_m: -3 max_z_m: 20 } statics_allowed: false }\nspawn {"),
            threads);
        for (int t = 0; t < 20 * 30; ++t) {
            crowd.tick();
        }
        EXPECT_GT(crowd.state().paths.counts().around_crowds, 200U);
        hash[threads == 1U ? 0 : 1] = crowd.world().state_hash();
    }
    EXPECT_EQ(hash[0], hash[1]);
}

}  // namespace
}  // namespace zoned::app
