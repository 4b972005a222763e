// Ghosts follow what changed of their entities alone, and are the same as if all had been looked
// at.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/context/zone_context.h"
#include "tests/integration/plain/plain_log.h"
#include "shared/core/rng.h"
#include "shared/core/state_hash.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace zoned::app::ghosts_test {
namespace {

/// Four zones with walkers, crates that sleep, and balls that are kicked about.
const char* const kText = R"(
world { name: "ghosts" seed: 3 min_x_m: -40 min_z_m: -40 max_x_m: 40 max_z_m: 40 }
zones { zone_grid { columns: 2 rows: 2 } ghost_margin_m: 25 handoff_hysteresis_m: 1 }
session { dev_mode_loopback: true }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } mass_kg: 80
  aura_m { normal: 20 } nimbus_m { normal: 20 } character { } }
type { name: "crate" box { x_m: 0.8 y_m: 0.8 z_m: 0.8 } mass_kg: 15 aura_m { normal: 20 } }
type { name: "walker" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } mass_kg: 70
  aura_m { normal: 20 } character { speed_mps: 3 } brain: "walk" }
brain { name: "walk"
  state { name: "walk" action: WANDER radius_m: 20
    transition { to: "rest" sensor: TIME_IN_STATE compare: ABOVE threshold: 3 } }
  state { name: "rest" action: IDLE
    transition { to: "walk" sensor: TIME_IN_STATE compare: ABOVE threshold: 2 } } }
type { name: "ball" sphere { radius_m: 0.4 } mass_kg: 5 drag_ps: 1 angular_drag_ps: 1
  aura_m { normal: 20 } }
scatter { type: "walker" count: 60 seed: 1 }
scatter { type: "ball" count: 60 seed: 4 }
scatter { type: "crate" count: 80 seed: 2 asleep: true }
scatter { type: "crate" count: 40 seed: 3 }
spawn { x_m: -5 z_m: 3 }
lod { position_bound_m: 0.05 }
)";

constexpr TypeIndex kBall = 3;

std::unique_ptr<World> make_world(const std::vector<std::string>& sets) {
    plain_log() = std::make_shared<scenario::PlainLog>();
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    EXPECT_TRUE(config::parse_settings(kText, sets, settings, errors))
        << config::format_errors("test", errors);
    return std::make_unique<World>(settings, 1);
}

/// Hash over all bodies of all zones: where those of ghosts are led is in no state hash of a tick.
std::uint64_t bodies_of(const World& world) {
    core::StateHash hash;
    for (const auto& zone : world.zones()) {
        zone->state().scene.hash(hash);
    }
    return hash.value();
}

/// Makes the next export and import look at everything.
void forget_exports(World& world) {
    for (const auto& zone : world.zones()) {
        zone->state().ghosts_out_rows.clear();
    }
}

/// Kicks some balls. They fall asleep while they still roll a little: then the bodies of their
/// ghosts arrive a tick later.
void kick(World& world, core::Rng rng) {
    for (const auto& zone : world.zones()) {
        zone::ZoneState& state = zone->state();
        std::vector<EntityId> balls;
        for (world::Row row = 0; row < state.entities.size(); ++row) {
            if (state.entities.type[row] == kBall && !state.entities.has(row, world::kGhost)) {
                balls.push_back(state.entities.id[row]);
            }
        }
        for (int k = 0; k < 6 && !balls.empty(); ++k) {
            const EntityId ball = balls[rng.below(static_cast<std::uint32_t>(balls.size()))];
            const auto speed = [&rng] {
                return static_cast<float>(rng.below(801)) * 0.01F - 4.0F;
            };
            const float x = speed();
            const Vec3 change(x, 0.0F, speed());
            zone::ZoneContext(state).add_velocity(ball, change);
        }
    }
}

/// How much of the exports was looked at.
struct Looked {
    std::size_t ticks_by_changes = 0;  ///< of 3,600
    std::size_t ghosts = 0;
    std::size_t looked_at = 0;
    std::uint64_t handoffs = 0;
};

/// Runs two worlds for 900 ticks: one follows changes, the other everything.
Looked run_both(const std::vector<std::string>& sets) {
    const std::unique_ptr<World> changes = make_world(sets);
    const std::unique_ptr<World> everything = make_world(sets);
    Looked out_of;
    std::vector<mailbox::OutboxItem> out;
    std::vector<std::uint64_t> a;
    std::vector<std::uint64_t> b;
    for (int t = 0; t < 900; ++t) {
        std::vector<mailbox::InboxItem> items;
        if (t == 50) {
            mailbox::Join join;
            join.client = ClientId(1);
            join.name = "player";
            items.emplace_back(join);
        }
        if (t % 40 == 20) {
            const core::Rng rng(7, static_cast<std::uint64_t>(t));
            kick(*changes, rng);
            kick(*everything, rng);
        }
        out.clear();
        changes->tick(items, out);
        forget_exports(*everything);
        out.clear();
        everything->tick(items, out);
        changes->hash_zones(a);
        everything->hash_zones(b);
        EXPECT_EQ(a, b) << "tick " << t;
        EXPECT_EQ(bodies_of(*changes), bodies_of(*everything)) << "tick " << t;
        if (::testing::Test::HasFailure()) {
            break;
        }
        for (const auto& zone : changes->zones()) {
            const zone::ZoneState& state = zone->state();
            if (!state.ghosts_out_anew) {
                ++out_of.ticks_by_changes;
                out_of.ghosts += state.ghosts_out.size();
                out_of.looked_at += state.ghosts_out_fresh.size();
            }
        }
    }
    out_of.handoffs = changes->handoffs();
    return out_of;
}

TEST(Ghosts, ThatFollowChangesAreThoseThatFollowEverything) {
    const Looked looked = run_both({});
    EXPECT_GT(looked.ticks_by_changes, 900U);  // neither way is left untried
    EXPECT_LT(looked.ticks_by_changes, 3500U);
    EXPECT_LT(2 * looked.looked_at, looked.ghosts);  // sleepers were left alone
    EXPECT_GT(looked.handoffs, 20U);
}

/// In long ticks a ball rolls on for a whole tick after its entity came to rest: the bodies of its
/// ghosts arrive when nothing of it changes any more.
TEST(Ghosts, ArriveAlsoWhenNothingChangesAnyMore) {
    const Looked looked = run_both({"world.tick_rate_hz=10", "replication.silence_ticks=5"});
    EXPECT_GT(looked.ticks_by_changes, 900U);
}

}  // namespace
}  // namespace zoned::app::ghosts_test
