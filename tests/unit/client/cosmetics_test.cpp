// Cosmetic particles: read from the description at login, and replayed as the sender would.
#include "client-sim/view/cosmetics.h"

#include "tests/unit/client/fake_server.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::view {
namespace {

motion::CosmeticEmitter chimney() {
    motion::CosmeticEmitter smoke;
    smoke.emitter.seed = 0xFEDCBA9876543210ull;
    smoke.emitter.start = 30;
    smoke.emitter.rate_hz = 12.5;
    smoke.emitter.position = Vec3(10.0F, 2.0F, -7.0F);
    smoke.emitter.spread = 0.4F;
    smoke.emitter.direction = Vec3(0.6F, 0.8F, 0.0F);
    smoke.emitter.cone_cosine = 0.9F;
    smoke.emitter.speed_min = 0.5F;
    smoke.emitter.speed_max = 2.0F;
    smoke.emitter.lifetime_min_s = 3.0F;
    smoke.emitter.lifetime_max_s = 5.0F;
    smoke.gravity = Vec3(0.0F, 0.4F, 0.0F);
    smoke.drag = 0.7F;
    smoke.wind = Vec3(1.5F, 0.0F, -0.5F);
    return smoke;
}

proto::WorldDescription described(const motion::CosmeticEmitter& from) {
    proto::WorldDescription w = test::FakeServer().world();
    proto::CosmeticSystem& system = *w.add_cosmetics();
    system.set_name("smoke");
    system.set_drag(from.drag);
    proto::Emitter& e = *system.add_emitters();
    for (int axis = 0; axis < 3; ++axis) {
        system.add_gravity(from.gravity[axis]);
        system.add_wind(from.wind[axis]);
        e.add_position(from.emitter.position[axis]);
        e.add_direction(from.emitter.direction[axis]);
    }
    e.set_seed(from.emitter.seed);
    e.set_start_tick(from.emitter.start);
    e.set_rate_hz(from.emitter.rate_hz);
    e.set_spread(from.emitter.spread);
    e.set_cone_cosine(from.emitter.cone_cosine);
    e.set_speed_min(from.emitter.speed_min);
    e.set_speed_max(from.emitter.speed_max);
    e.set_lifetime_min_s(from.emitter.lifetime_min_s);
    e.set_lifetime_max_s(from.emitter.lifetime_max_s);
    return w;
}

TEST(Cosmetics, AreReplayedBitForBitAsTheyWereTold) {
    const auto world = test::read_world(described(chimney()));
    ASSERT_TRUE(world.ok());
    ASSERT_EQ(world->cosmetics.size(), 1u);
    EXPECT_EQ(world->cosmetics[0].name, "smoke");
    ASSERT_EQ(world->cosmetics[0].emitters.size(), 1u);
    for (const Tick tick : {29, 30, 31, 75, 200, 100'000}) {
        std::vector<motion::CosmeticParticle> here;
        std::vector<motion::CosmeticParticle> there;
        motion::replay(world->cosmetics[0].emitters[0], tick, world->tick_s, here);
        motion::replay(chimney(), tick, world->tick_s, there);
        ASSERT_EQ(here.size(), there.size()) << tick;
        EXPECT_EQ(here.empty(), tick <= 30) << tick;
        for (std::size_t i = 0; i < here.size(); ++i) {
            EXPECT_EQ(here[i].index, there[i].index);
            EXPECT_EQ(here[i].position, there[i].position);
            EXPECT_EQ(here[i].velocity, there[i].velocity);
            EXPECT_EQ(here[i].age_share, there[i].age_share);
        }
    }
}

TEST(Cosmetics, AreRefusedWhereAClientCouldNotReplayThem) {
    const proto::WorldDescription good = described(chimney());
    EXPECT_TRUE(test::read_world(good).ok());
    const auto refused = [&](auto&& spoil) {
        proto::WorldDescription w = good;
        spoil(*w.mutable_cosmetics(0), *w.mutable_cosmetics(0)->mutable_emitters(0));
        return !test::read_world(w).ok();
    };
    EXPECT_TRUE(refused([](auto& s, auto&) { s.clear_gravity(); }));
    EXPECT_TRUE(refused([](auto& s, auto&) { s.set_wind(0, NAN); }));
    EXPECT_TRUE(refused([](auto& s, auto&) { s.set_drag(-1.0F); }));
    EXPECT_TRUE(refused([](auto&, auto& e) { e.clear_position(); }));
    EXPECT_TRUE(refused([](auto&, auto& e) { e.set_direction(0, 3.0F); }));
    EXPECT_TRUE(refused([](auto&, auto& e) { e.set_rate_hz(0.0); }));
    EXPECT_TRUE(refused([](auto&, auto& e) { e.set_lifetime_min_s(0.0F); }));
    EXPECT_TRUE(refused([](auto&, auto& e) { e.set_start_tick(-5); }));
    // A hostile server must not hang its clients.
    EXPECT_TRUE(refused([](auto&, auto& e) { e.set_rate_hz(1e9); }));
}

}  // namespace
}  // namespace zoned::view
