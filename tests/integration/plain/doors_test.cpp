// Doors in a zone: solid while they are shut, for characters, bodies and rays of any time.
#include "server/app/world/world.h"
#include "server/zone/context/zone_context.h"
#include "server/zone/viewers/lag_compensation.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"

#include <gtest/gtest.h>

#include <optional>

namespace zoned::app::doors_test {
namespace {

/// A flat zone with a door across x = 0 that is open in ticks [60, 120) of 600.
class DoorInAZone : public testing::Test {
  protected:
    DoorInAZone() {
        plain_log() = std::make_shared<scenario::PlainLog>();
        settings_ = scenario::small_world(1, 1, 100.0);
        config::NamedDoor gate;
        gate.name = "gate";
        gate.door.box.centre = Vec3(0.0F, 1.5F, 0.0F);
        gate.door.box.half_extents = Vec3(0.2F, 1.5F, 4.0F);
        gate.door.times.period = 600;
        gate.door.times.open = {{60, 120}};
        settings_.doors = {gate};
        settings_.types[scenario::kBall].rewindable = true;
        settings_.rewind.most_ticks = 30;
    }

    void begin() { world_.emplace(settings_, 1); }

    EntityId spawn(TypeIndex type, const Vec3& at, const Vec3& velocity, bool asleep = false) {
        zone::SpawnDef def;
        def.type = type;
        def.position = at;
        def.velocity = velocity;
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

    bool ray_now() {
        physics::QueryHit hit;
        return state().scene.query().ray({Vec3(-5, 1, 1), Vec3::UnitX(), 10.0F}, {}, hit);
    }

    config::Settings settings_;
    std::optional<World> world_;
    std::vector<mailbox::OutboxItem> out_;
};

TEST_F(DoorInAZone, StopsRaysAndLinesOfSightWhileItIsShut) {
    begin();
    to(59);
    EXPECT_TRUE(ray_now());
    EXPECT_FALSE(zone().report().plan.has(zone::Pass::kDoors));
    to(60);
    EXPECT_TRUE(zone().report().plan.has(zone::Pass::kDoors)) << "it opens in this tick";
    EXPECT_FALSE(ray_now());
    to(119);
    EXPECT_FALSE(ray_now());
    to(120);
    EXPECT_TRUE(ray_now());
    EXPECT_EQ(zone().report().plan.reason[0], "doors open or shut");
    to(121);
    EXPECT_EQ(zone().report().plan.reason[0], "no door opens or shuts");
}

TEST_F(DoorInAZone, IsMetByRaysIntoThePastAsItWasThen) {
    begin();
    to(63);
    const auto hits = [this](Tick tick) {
        zone::Seen seen;
        seen.view = zone::Seen::DisplayedTime::kPast;
        seen.tick = tick;
        return zone::ray_cast_as_seen(
                   state(), ClientId(1), seen, Vec3(-5, 1, 1), Vec3::UnitX(), 10.0F, EntityId())
            .hit;
    };
    EXPECT_TRUE(hits(58));
    EXPECT_TRUE(hits(59));
    EXPECT_FALSE(hits(60));
    EXPECT_FALSE(hits(62));
    to(123);
    EXPECT_FALSE(hits(118));
    EXPECT_FALSE(hits(119));
    EXPECT_TRUE(hits(120));
}

TEST_F(DoorInAZone, HoldsABallAndLetsTheNextOneThrough) {
    begin();
    to(10);
    const EntityId held = spawn(scenario::kBall, Vec3(-3.0F, 0.5F, 0.0F), Vec3(8.0F, 0.0F, 0.0F));
    to(55);
    EXPECT_LT(place(held).x(), -0.2F - 0.5F + 0.02F);
    to(61);
    const EntityId free = spawn(scenario::kBall, Vec3(-3.0F, 0.5F, 2.0F), Vec3(8.0F, 0.0F, 0.0F));
    to(110);
    EXPECT_GT(place(free).x(), 1.0F);
}

TEST_F(DoorInAZone, WakesWhatLeantOnItAndWhatItShutsOn) {
    begin();
    // A crate that sleeps on top of the shut door, and one that sleeps where it stood open.
    const EntityId above = spawn(scenario::kCrate, Vec3(0.0F, 3.5F, -1.0F), Vec3::Zero());
    const EntityId within = spawn(scenario::kCrate, Vec3(0.4F, 0.5F, 2.0F), Vec3::Zero(), true);
    to(59);
    EXPECT_NEAR(place(above).y(), 3.5F, 0.05F);
    to(119);
    EXPECT_LT(place(above).y(), 3.0F) << "it fell when the door opened";
    to(240);
    EXPECT_GT(std::abs(place(within).x()), 0.2F + 0.5F - 0.03F) << "it was pushed out";
}

TEST_F(DoorInAZone, PushesOutACharacterThatStandsInItWithNobodyThere) {
    begin();
    to(70);
    const EntityId standing = spawn(scenario::kPlayer, Vec3(0.1F, 0.9F, 0.0F), Vec3::Zero());
    to(119);
    EXPECT_EQ(place(standing), Vec3(0.1F, 0.9F, 0.0F));
    to(140);
    EXPECT_NEAR(place(standing).x(), 0.2F + 0.4F, 0.01F);
    EXPECT_TRUE(state().entities.has(state().entities.find(standing), world::kAtRest));
    EXPECT_FALSE(zone().report().plan.has(zone::Pass::kMovement)) << "and all is at rest again";
}

TEST_F(DoorInAZone, CostsAWorldWithoutDoorsNoPass) {
    settings_.doors.clear();
    begin();
    to(130);
    EXPECT_FALSE(zone().report().plan.has(zone::Pass::kDoors));
    EXPECT_EQ(zone().report().plan.reason[0], "no doors");
    EXPECT_TRUE(state().doors.body.empty());
}

}  // namespace
}  // namespace zoned::app::doors_test
