// Getting on vehicles and off, and ragdolls.
#include "tests/unit/rules/fake_zone.h"

#include <gtest/gtest.h>

namespace zoned::rules::test {
namespace {

struct Vehicles : ::testing::Test {
    FakeZone zone;
    EntityId first = zone.join(1, Vec3::Zero());
    EntityId second = zone.join(2, Vec3(0.0F, 0.0F, 1.0F));
    EntityId car = zone.put(kCrate, Vec3(2.0F, 0.0F, 0.0F));

    void ride(std::uint32_t client, EntityId avatar, EntityId entity) {
        sandbox::Ride command;
        command.set_entity(entity.value);
        zone.command(client, avatar, sandbox::COMMAND_RIDE, command);
    }

    Vehicles() { zone.seats[car].resize(1); }
};

TEST_F(Vehicles, TakeWhoIsInReachUntilTheyAreFull) {
    ride(1, first, car);
    EXPECT_EQ(zone.denial(), "");
    EXPECT_EQ(zone.carrier_of(first), car);
    EXPECT_EQ(zone.entities().stance[zone.entities().find(first)],
              static_cast<std::uint8_t>(world::Stance::kRiding));
    ride(2, second, car);
    EXPECT_EQ(zone.denial(), "no free seat");
    ride(1, first, EntityId());
    EXPECT_FALSE(zone.carrier_of(first));
    // The next to the vehicle: nothing else is there.
    EXPECT_LT((zone.position(first) - zone.position(car)).norm(), 3.5F);
    ride(2, second, car);
    EXPECT_EQ(zone.carrier_of(second), car);
}

TEST_F(Vehicles, AreOutOfReachFromFarAway) {
    zone.position(first) = Vec3(-5.0F, 0.0F, 0.0F);
    ride(1, first, car);
    EXPECT_EQ(zone.denial(), "out of reach");
    zone.tick_seconds(1.0F);
    ride(1, first, EntityId());
    EXPECT_EQ(zone.denial(), "you ride on nothing");
    zone.tick_seconds(1.0F);
    ride(1, first, EntityId(4000));
    EXPECT_EQ(zone.denial(), "no such thing");
    zone.tick_seconds(1.0F);
    zone.position(first) = Vec3::Zero();
    ride(1, first, second);
    EXPECT_EQ(zone.denial(), "no free seat");
}

TEST(Ragdolls, LieWhereSomebodyWasKilledAndAreGoneLater) {
    FakeZone zone(
        1, Vec3d::Zero(), {{"ragdoll_type", "crate"}, {"ragdoll_s", "2"}, {"damage", "100"}});
    const EntityId shooter = zone.join(1, Vec3::Zero());
    zone.join(2, Vec3(10.0F, 0.0F, 0.0F));
    const EntityId last = zone.put(kCrate, Vec3(0.0F, 50.0F, 0.0F));
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(3.0F, 0.0F, 0.0F));
    zone.tick_seconds(3.2F);  // the killed client does not answer
    const EntityId ragdoll(last.value + 4);
    ASSERT_TRUE(zone.exists(ragdoll));
    EXPECT_NEAR(zone.position(ragdoll).x(), 10.0F, 1e-5F);
    zone.tick_seconds(1.5F);
    EXPECT_TRUE(zone.exists(ragdoll));
    zone.tick_seconds(1.0F);
    EXPECT_FALSE(zone.exists(ragdoll));
}

}  // namespace
}  // namespace zoned::rules::test
