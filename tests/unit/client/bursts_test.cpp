// Cosmetic bursts: computed from an event alone, the same as at the emitter. Malformed and surplus
// bursts are refused and counted.
#include "client-sim/view/bursts.h"

#include "client-sim/view/view.h"
#include "tests/unit/client/fake_server.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>

namespace zoned::view {
namespace {

const motion::BurstKind kShards{0.6F, 0.3F, 0.05F, 0.5F, 2.0F};

/// System 0 has no burst, system 1 has.
proto::WorldDescription told_description() {
    proto::WorldDescription w = test::FakeServer().world();
    for (const char* name : {"rain", "shards"}) {
        proto::CosmeticSystem& system = *w.add_cosmetics();
        system.set_name(name);
        system.set_drag(0.4F);
        for (int axis = 0; axis < 3; ++axis) {
            system.add_gravity(axis == 1 ? -9.81F : 0.0F);
            system.add_wind(axis == 0 ? 2.0F : 0.0F);
        }
    }
    proto::CosmeticSystem::Burst& burst = *w.mutable_cosmetics(1)->mutable_burst();
    burst.set_cone_cosine(kShards.cone_cosine);
    burst.set_slowest(kShards.slowest);
    burst.set_spread(kShards.spread);
    burst.set_lifetime_min_s(kShards.lifetime_min_s);
    burst.set_lifetime_max_s(kShards.lifetime_max_s);
    return w;
}

std::shared_ptr<const WorldInfo> told_world() {
    const auto read = test::read_world(told_description());
    EXPECT_TRUE(read.ok());
    return std::make_shared<const WorldInfo>(*read);
}

proto::ParticleBurst payload(std::uint32_t count = 12) {
    proto::ParticleBurst told;
    told.set_system(1);
    told.set_seed(0xFEDCBA9876543210ull);
    told.set_count(count);
    for (const float n : {10.5F, 1.25F, -7.0F}) {
        told.add_position(n);
    }
    for (const float n : {1.0F, 3.0F, -0.5F}) {
        told.add_velocity(n);
    }
    return told;
}

proto::Event sent(const proto::ParticleBurst& told, std::int64_t tick = 100) {
    proto::Event out;
    out.set_kind(proto::CORE_EVENT_PARTICLE_BURST);
    out.set_tick(tick);
    out.set_payload(told.SerializeAsString());
    return out;
}

/// As the client reads it.
wire::EventMessage event(const proto::ParticleBurst& told, std::int64_t tick = 100) {
    return test::received<wire::EventMessage>(sent(told, tick));
}

TEST(Bursts, AreReplayedBitForBitAsWhoeverLetThemOutWould) {
    const auto w = told_world();
    Bursts bursts(*w);
    ASSERT_EQ(bursts.apply(event(payload()), 100), Bursts::BurstOutcome::kTaken);
    motion::CosmeticEmitter mine;
    mine.gravity = Vec3(0.0F, -9.81F, 0.0F);
    mine.drag = 0.4F;
    mine.wind = Vec3(2.0F, 0.0F, 0.0F);
    mine.emitter = motion::emitter_of(
        kShards,
        {0xFEDCBA9876543210ull, 100, Vec3(10.5F, 1.25F, -7.0F), Vec3(1.0F, 3.0F, -0.5F), 12});
    for (const Tick tick : {99, 100, 101, 115, 130, 200}) {
        std::vector<motion::CosmeticParticle> here;
        std::vector<motion::CosmeticParticle> there;
        bursts.replay(tick, here);
        motion::replay(mine, tick, w->tick_s, there);
        ASSERT_EQ(here.size(), there.size()) << tick;
        // None is born before, all live for half a second, none for more than two.
        EXPECT_TRUE(tick > 100 || here.empty()) << tick;
        EXPECT_TRUE(tick <= 100 || tick > 115 || here.size() == 12) << tick;
        EXPECT_TRUE(tick < 200 || here.empty());
        for (std::size_t i = 0; i < here.size(); ++i) {
            EXPECT_EQ(here[i].position, there[i].position);
            EXPECT_EQ(here[i].velocity, there[i].velocity);
            EXPECT_EQ(here[i].age_share, there[i].age_share);
        }
    }
}

TEST(Bursts, CostAFewDozenBytesAnEvent) {
    // Tags and lengths 8, seed 8, six floats 24, system and count 2.
    EXPECT_LE(payload().ByteSizeLong(), 44u);
    EXPECT_LE(sent(payload()).ByteSizeLong(), 56u);
}

TEST(Bursts, ThatAreMalformedAreRefused) {
    const auto w = told_world();
    Bursts bursts(*w);
    const auto outcome = [&](const std::function<void(proto::ParticleBurst&)>& spoil) {
        proto::ParticleBurst told = payload();
        spoil(told);
        return bursts.apply(event(told), 100);
    };
    constexpr auto kMalformed = Bursts::BurstOutcome::kMalformed;
    EXPECT_EQ(outcome([](auto& b) { b.set_system(0); }), kMalformed) << "it has no burst";
    EXPECT_EQ(outcome([](auto& b) { b.set_system(2); }), kMalformed);
    EXPECT_EQ(outcome([](auto& b) { b.set_count(0); }), kMalformed);
    EXPECT_EQ(outcome([](auto& b) { b.set_count(1001); }), kMalformed);
    EXPECT_EQ(outcome([](auto& b) { b.set_count(UINT32_MAX); }), kMalformed);
    EXPECT_EQ(outcome([](auto& b) { b.clear_position(); }), kMalformed);
    EXPECT_EQ(outcome([](auto& b) { b.add_position(1.0F); }), kMalformed);
    EXPECT_EQ(outcome([](auto& b) { b.set_position(1, NAN); }), kMalformed);
    EXPECT_EQ(outcome([](auto& b) { b.clear_velocity(); }), kMalformed);
    EXPECT_EQ(outcome([](auto& b) { b.set_velocity(2, INFINITY); }), kMalformed);
    EXPECT_EQ(outcome([](auto& b) { b.set_velocity(0, 1e30F); }), kMalformed);
    EXPECT_EQ(bursts.apply(event(payload(), -1), 100), kMalformed);
    wire::EventMessage garbage = event(payload());
    garbage.payload = "\xFF\xFF\xFF";
    EXPECT_EQ(bursts.apply(garbage, 100), kMalformed);
    EXPECT_EQ(bursts.size(), 0u);
    EXPECT_EQ(outcome([](auto&) {}), Bursts::BurstOutcome::kTaken) << "unspoilt";
}

TEST(Bursts, OfAHostileServerTakeABoundedPlace) {
    const auto w = told_world();
    Bursts many(*w);
    Bursts large(*w);
    std::size_t refused = 0;
    for (int i = 0; i < 5000; ++i) {
        // Far in the future, so that none is ever over.
        const bool room =
            many.apply(event(payload(1), INT64_MAX), 100) == Bursts::BurstOutcome::kTaken;
        EXPECT_EQ(room, i < static_cast<int>(Bursts::kMost)) << i;
        refused +=
            large.apply(event(payload(1000), INT64_MAX), 100) == Bursts::BurstOutcome::kNoRoom ? 1
                                                                                               : 0;
    }
    EXPECT_EQ(many.size(), Bursts::kMost);
    EXPECT_EQ(large.size(), Bursts::kMostAlive / 1000);
    EXPECT_EQ(refused, 5000 - Bursts::kMostAlive / 1000);
    std::vector<motion::CosmeticParticle> sparks;
    large.replay(INT64_MAX, sparks);
    large.replay(0, sparks);
    EXPECT_TRUE(sparks.empty());
}

TEST(Bursts, ThatAreOverMakeRoomForOthers) {
    const auto w = told_world();
    Bursts bursts(*w);
    for (std::size_t i = 0; i < Bursts::kMost; ++i) {
        ASSERT_EQ(bursts.apply(event(payload(1), 100), 100), Bursts::BurstOutcome::kTaken);
    }
    // Two seconds of 30 ticks: at 161 the last may live yet, at 162 none does.
    EXPECT_EQ(bursts.apply(event(payload(1), 161), 161), Bursts::BurstOutcome::kNoRoom);
    EXPECT_EQ(bursts.apply(event(payload(1), 162), 162), Bursts::BurstOutcome::kTaken);
    EXPECT_EQ(bursts.size(), 1u);
}

TEST(Bursts, AreCountedByTheViewThatTakesThem) {
    View view(told_world(), {}, nullptr);
    view.apply(event(payload()));
    view.apply(event(payload(0)));
    wire::EventMessage other = event(payload(0));
    other.kind = 16;  // of the rules
    view.apply(other);
    EXPECT_EQ(view.stats().bursts, 1u);
    EXPECT_EQ(view.stats().bursts_malformed, 1u);
    for (std::size_t i = 0; i < Bursts::kMost; ++i) {
        view.apply(event(payload(1)));
    }
    EXPECT_EQ(view.stats().bursts_refused, 1u);
    EXPECT_EQ(view.bursts().size(), Bursts::kMost);
}

TEST(Cosmetics, WithABurstThatNobodyCouldReplayAreRefusedAtLogin) {
    const auto refused = [](const std::function<void(proto::CosmeticSystem::Burst&)>& spoil) {
        proto::WorldDescription w = told_description();
        spoil(*w.mutable_cosmetics(1)->mutable_burst());
        return !test::read_world(w).ok();
    };
    EXPECT_FALSE(refused([](auto&) {}));
    EXPECT_TRUE(refused([](auto& b) { b.set_slowest(-0.1F); }));
    EXPECT_TRUE(refused([](auto& b) { b.set_cone_cosine(2.0F); }));
    EXPECT_TRUE(refused([](auto& b) { b.set_spread(INFINITY); }));
    EXPECT_TRUE(refused([](auto& b) { b.set_lifetime_min_s(0.0F); }));
}

}  // namespace
}  // namespace zoned::view
