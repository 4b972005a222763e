// Platforms in a zone: characters and bodies ride on them, rays hit them where they were.
#include "server/app/world/world.h"
#include "server/zone/viewers/lag_compensation.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"

#include <gtest/gtest.h>

#include <optional>

namespace zoned::app::platforms_test {
namespace {

/// A flat zone with a platform of 4 x 4 m that goes 9 m aside and 3 m up from tick 120 on, and back
/// from tick 330 on, at 3 m/s.
class PlatformInAZone : public testing::Test {
  protected:
    PlatformInAZone() {
        plain_log() = std::make_shared<scenario::PlainLog>();
        settings_ = scenario::small_world(1, 1, 100.0);
        config::NamedPlatform lift;
        lift.name = "lift";
        lift.platform.box.centre = Vec3(0.0F, 0.9F, 0.0F);
        lift.platform.box.half_extents = Vec3(2.0F, 0.1F, 2.0F);
        lift.platform.box.friction = 1.0F;
        lift.platform.path.stops = {{Vec3::Zero(), 0}, {Vec3(9.0F, 3.0F, 0.0F), 90}};
        lift.platform.path.wait = 120;
        settings_.platforms = {lift};
        settings_.types[scenario::kBall].rewindable = true;
        settings_.rewind.most_ticks = 30;
    }

    void begin() { world_.emplace(settings_, 1); }

    EntityId spawn(TypeIndex type, const Vec3& at, bool asleep = false) {
        zone::SpawnDef def;
        def.type = type;
        def.position = at;
        def.asleep = asleep;
        return world_->zones()[0]->spawn(def);
    }

    zone::Zone& zone() { return *world_->zones()[0]; }

    zone::ZoneState& state() { return zone().state(); }

    void to(Tick tick) {
        while (state().now < tick) {
            out_.clear();
            world_->tick({}, out_);
        }
    }

    Vec3 place(EntityId id) {
        const world::Entities& e = state().entities;
        return e.position[e.find(id)];
    }

    Vec3 relative(EntityId id) {
        return place(id) - state().settings.statics->platform_box(0, state().now).centre;
    }

    bool at_rest(EntityId id) {
        const world::Entities& e = state().entities;
        return e.has(e.find(id), world::kAtRest);
    }

    config::Settings settings_;
    std::optional<World> world_;
    std::vector<mailbox::OutboxItem> out_;
};

TEST_F(PlatformInAZone, IsABodyThatIsWhereItsTimesSay) {
    begin();
    for (Tick tick = 1; tick < 900; ++tick) {
        to(tick);
        const Vec3 wanted = state().settings.statics->platform_box(0, tick).centre;
        ASSERT_LT((state().scene.state(state().platforms[0]).position - wanted).norm(), 1e-5F)
            << tick;
    }
}

TEST_F(PlatformInAZone, TakesAlongACharacterThatRests) {
    begin();
    const EntityId rider = spawn(scenario::kPlayer, Vec3(0.3F, 1.95F, -0.4F));
    to(119);
    EXPECT_TRUE(at_rest(rider));
    EXPECT_FALSE(zone().report().plan.has(zone::Pass::kMovement));
    const Vec3 before = relative(rider);
    for (Tick tick = 120; tick < 900; ++tick) {
        to(tick);
        // Half a unit in the last place for each power of two that a coordinate passes the first
        // time, up to 16 m.
        ASSERT_LT((relative(rider) - before).norm(), 2e-6F) << tick;
    }
    EXPECT_TRUE(at_rest(rider));
    to(215);
    EXPECT_FALSE(zone().report().plan.has(zone::Pass::kMovement)) << "it rests at the stop";
}

TEST_F(PlatformInAZone, TakesAlongBodiesAndLetsThemSleep) {
    begin();
    const EntityId crate = spawn(scenario::kCrate, Vec3(0.0F, 1.5F, 0.0F), true);
    const EntityId far = spawn(scenario::kCrate, Vec3(20.0F, 0.5F, 0.0F), true);
    to(119);
    EXPECT_EQ(state().scene.awake_count(), 0U) << "it sleeps on the platform";
    const Vec3 before = relative(crate);
    to(150);
    EXPECT_GT(state().scene.awake_count(), 0U) << "the platform has woken it";
    EXPECT_EQ(place(far), Vec3(20.0F, 0.5F, 0.0F));
    to(212);
    // It takes a moment to be as fast as the platform, and to come to a stop with it.
    EXPECT_LT((relative(crate) - before).norm(), 1.0F);
    EXPECT_GT(place(crate).y(), 4.4F);
    to(320);
    EXPECT_EQ(state().scene.awake_count(), 0U) << "it sleeps again";
    EXPECT_TRUE(at_rest(crate));
    to(430);
    EXPECT_LT((relative(crate) - before).norm(), 2.0F);
    EXPECT_NEAR(relative(crate).y(), 0.6F, 0.02F);
}

TEST_F(PlatformInAZone, PushesABallAside) {
    settings_.platforms[0].platform.box.centre.y() = 0.5F;
    settings_.platforms[0].platform.box.half_extents.y() = 0.45F;
    settings_.platforms[0].platform.path.stops[1].offset.y() = 0.0F;
    begin();
    const EntityId ball = spawn(scenario::kBall, Vec3(5.0F, 0.5F, 0.0F), true);
    to(212);
    EXPECT_GT(place(ball).x(), 11.0F);
    EXPECT_LT(place(ball).norm(), 40.0F) << "it was not shot away";
}

TEST_F(PlatformInAZone, IsMetByRaysWhereItWasThen) {
    begin();
    to(180);
    const auto hits = [this](Tick tick, float x) {
        zone::Seen seen;
        seen.view = zone::Seen::DisplayedTime::kPast;
        seen.tick = tick;
        return zone::ray_cast_as_seen(state(),
                                      ClientId(1),
                                      seen,
                                      Vec3(x, 8.0F, 0.0F),
                                      -Vec3::UnitY(),
                                      7.5F,
                                      EntityId())
            .hit;
    };
    // At tick 175 it is 5.5 m on its way, 2.9 m at tick 149.
    EXPECT_TRUE(hits(175, 7.0F));
    EXPECT_FALSE(hits(152, 7.0F));
    EXPECT_TRUE(hits(152, 1.3F));
    EXPECT_FALSE(hits(175, 1.3F));
}

TEST_F(PlatformInAZone, GoesOnWhereItIsAfterTheWorldWasFrozen) {
    begin();
    const EntityId crate = spawn(scenario::kCrate, Vec3(0.0F, 1.5F, 0.0F));
    to(130);
    state().frozen = true;
    to(190);
    state().frozen = false;
    to(230);
    const Vec3 wanted = state().settings.statics->platform_box(0, state().now).centre;
    EXPECT_LT((state().scene.state(state().platforms[0]).position - wanted).norm(), 1e-4F);
    EXPECT_LT(place(crate).norm(), 15.0F) << "it was not shot away";
}

TEST_F(PlatformInAZone, IsNoGroundForAgents) {
    begin();
    ASSERT_NE(state().fixed_ground, nullptr);
    EXPECT_TRUE(state().fixed_ground->platforms().empty());
    EXPECT_EQ(state().settings.statics->boxes().size(), state().fixed_ground->boxes().size());
}

TEST_F(PlatformInAZone, CostsAWorldWithoutPlatformsNoPass) {
    settings_.platforms.clear();
    begin();
    to(130);
    EXPECT_FALSE(zone().report().plan.has(zone::Pass::kPlatforms));
    EXPECT_EQ(zone().report().plan.reason[static_cast<std::size_t>(zone::Pass::kPlatforms)],
              "no platforms");
    EXPECT_EQ(state().platforms.capacity(), 0U);
    EXPECT_EQ(state().fixed_ground, nullptr);
}

}  // namespace
}  // namespace zoned::app::platforms_test
