// A platform that rules move over a border between zones: it takes NPCs, bodies and sleepers along,
// and goes on after a snapshot as if nothing had been.
#include "server/zone/context/zone_context.h"
#include "tests/integration/plain/crowd_world.h"
#include "tests/integration/plain/plain_log.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace zoned::app {
namespace {

using test::Crowd;

constexpr Tick kBegins = 30;  // four seconds of travel at 20 Hz, and back from tick 140 on
constexpr Tick kBack = 140;
constexpr Tick kTravel = 80;

constexpr const char* kFerryWorld = R"(
world { name: "ferry" seed: 5 tick_rate_hz: 20 min_x_m: -50 min_z_m: -50 max_x_m: 50 max_z_m: 50 }
zones { zone_grid { columns: 2 rows: 1 } }
type { name: "player" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } nimbus_m { normal: 50 } character { } }
type { name: "crate" box { } mass_kg: 20 friction: 0.8 aura_m { normal: 50 } }
type { name: "guard" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } aura_m { normal: 50 } character { } brain: "stand" }
brain { name: "stand" state { name: "stand" action: IDLE } }
platform {
  name: "ferry" moved_by: RULES speed_mps: 2
  box { x_m: -4 y_m: 0.5 size { x_m: 6 y_m: 0.2 z_m: 6 } }
  stop { x_m: 4 y_m: 0.5 }
}
entity { type: "guard" name: "guard" x_m: -5 y_m: 1.5 z_m: 1 }
entity { type: "crate" name: "crate" x_m: -3 y_m: 1.1 z_m: -1 asleep: true }
entity { type: "crate" name: "stays" x_m: -20 y_m: 0.5 z_m: -1 asleep: true }
spawn { x_m: -10 z_m: -10 }
lod { position_bound_m: 0.5 orientation_bound_rad: 0.3 }
session { dev_mode_loopback: true }
)";

class MovedPlatforms : public ::testing::Test {
  protected:
    MovedPlatforms() { plain_log() = std::make_shared<scenario::PlainLog>(); }

    ~MovedPlatforms() override { plain_log() = std::make_shared<scenario::PlainLog>(); }

    /// Each course is announced a second before it begins.
    static void move(zone::RulesContext& c) {
        if (c.zone() == ZoneId(1) && (c.now() == kBegins - 20 || c.now() == kBack - 20)) {
            EXPECT_TRUE(c.move_platform("ferry", c.now() < kBack - 20 ? 1 : 0, 1.0));
        }
    }

    static std::unique_ptr<Crowd> made(unsigned threads = 1) {
        plain_log()->busy = true;
        plain_log()->each_tick = move;
        return std::make_unique<Crowd>(kFerryWorld, threads);
    }

    /// In coordinates of the world, wherever it is owned.
    static Vec3 place(Crowd& in, const std::string& name) {
        for (const auto& zone : in.world().zones()) {
            const zone::ZoneState& state = zone->state();
            const zone::ZoneContext context(zone->state());
            const EntityId id = context.entity_named(name);
            const world::Row row = state.entities.find(id);
            if (row != world::kNoRow && !state.entities.has(row, world::kGhost)) {
                return state.entities.position[row] +
                       state.settings.region().origin().cast<float>();
            }
        }
        ADD_FAILURE() << "nobody owns " << name;
        return Vec3::Zero();
    }

    static Vec3 ferry(Crowd& in) {
        const zone::ZoneState& state = in.state();
        return state.settings.statics->platform_box(0, state.now).centre +
               state.settings.region().origin().cast<float>();
    }

    static void to(Crowd& in, Tick tick) {
        while (in.world().now() < tick) {
            in.tick();
        }
    }

    static std::vector<std::uint64_t> next_hashes(Crowd& of, int ticks) {
        std::vector<std::uint64_t> run;
        for (int i = 0; i < ticks; ++i) {
            of.tick();
            std::vector<std::uint64_t> all;
            of.world().hash_zones(all);
            run.insert(run.end(), all.begin(), all.end());
        }
        return run;
    }
};

TEST_F(MovedPlatforms, TakeNpcsAndBodiesOverABorderAndBack) {
    const auto world = made();
    to(*world, kBegins - 1);
    EXPECT_NEAR(ferry(*world).x(), -4.0F, 1e-4F);
    const Vec3 guard = place(*world, "guard") - ferry(*world);
    const Vec3 crate = place(*world, "crate") - ferry(*world);
    for (Tick tick = kBegins; tick < kBegins + kTravel; ++tick) {
        to(*world, tick);
        // A tick of travel when the guard passes to the other zone, and rounding.
        ASSERT_LT((place(*world, "guard") - ferry(*world) - guard).norm(), 0.1F + 1e-4F) << tick;
    }
    to(*world, kBack - 1);
    EXPECT_NEAR(ferry(*world).x(), 4.0F, 1e-4F);
    EXPECT_GT(place(*world, "guard").x(), 2.0F);
    // The crate slides until friction has made it as fast: v^2 / (2 mu g), 0.26 m, at both ends.
    EXPECT_NEAR((place(*world, "crate") - ferry(*world) - crate).norm(), 0.0F, 0.6F);
    EXPECT_GT(world->world().handoffs(), 1U);
    to(*world, kBack + kTravel + 20);
    EXPECT_NEAR(ferry(*world).x(), -4.0F, 1e-4F);
    EXPECT_LT((place(*world, "guard") - ferry(*world) - guard).norm(), 0.1F + 1e-4F);
    EXPECT_EQ(place(*world, "stays"), Vec3(-20.0F, 0.5F, -1.0F));
}

TEST_F(MovedPlatforms, GoOnAfterASnapshotAsIfNothingHadBeen) {
    const auto world = made();
    // Announced; near the border; half over it; at its stop; announced again; on the way back.
    for (const Tick at : {20, 62, 75, 115, 130, 180}) {
        to(*world, at);
        std::vector<std::uint8_t> bytes;
        ASSERT_EQ(world->world().save(bytes), "");
        const auto copy = made();
        ASSERT_EQ(copy->world().load(bytes), "");
        EXPECT_EQ(ferry(*copy), ferry(*world));
        const auto copied = next_hashes(*copy, 150);
        // The original has the other stages to come: a world of its own is compared.
        const auto again = made();
        to(*again, at);
        ASSERT_EQ(copied, next_hashes(*again, 150)) << at;
    }
}

TEST_F(MovedPlatforms, AreTheSameOnAnyNumberOfThreads) {
    const auto one = next_hashes(*made(1), 260);
    EXPECT_EQ(next_hashes(*made(2), 260), one);
    EXPECT_EQ(next_hashes(*made(4), 260), one);
}

}  // namespace
}  // namespace zoned::app
