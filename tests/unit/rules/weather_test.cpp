#include "tests/unit/rules/fake_zone.h"

#include <gtest/gtest.h>

#include <utility>

namespace zoned::rules::test {
namespace {

TEST(Debris, FliesOffPropsThatAreShotAndNotOffPlayers) {
    FakeZone zone;
    const EntityId shooter = zone.join(1, Vec3::Zero());
    const EntityId crate = zone.put(kCrate, Vec3(5.0F, 0.7F, 0.0F));
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
    ASSERT_EQ(zone.emitted.size(), 1u);
    EXPECT_EQ(zone.emitted[0].system, "debris");
    EXPECT_EQ(zone.emitted[0].count, 12u);
    EXPECT_LT(zone.emitted[0].velocity.x(), 0.0F) << "back to the shooter";
    zone.despawn(crate);
    zone.join(2, Vec3(10.0F, 0.0F, 0.0F));
    zone.tick(8);
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
    EXPECT_EQ(zone.emitted.size(), 1u);
}

TEST(Debris, FliesWherePropsMeetHardAndInTheOwnersZoneAlone) {
    FakeZone west(1);
    FakeZone east(2);
    const EntityId mine = west.put(kBall, Vec3::Zero());
    const EntityId other = east.put(kBall, Vec3::Zero());
    west.show_ghost(east, other);
    east.show_ghost(west, mine);
    zone::EntityContact contact;
    contact.a = mine;
    contact.b = other;
    contact.approach_speed = 6.0F;
    west.game.on_contact(west, contact);
    EXPECT_TRUE(west.emitted.empty()) << "no harder than impact_mps";
    contact.approach_speed = 6.1F;
    west.game.on_contact(west, contact);
    east.game.on_contact(east, contact);
    EXPECT_EQ(west.emitted.size(), 1u);
    EXPECT_EQ(east.emitted.size(), 0u);
    contact.a = EntityId();  // the ground
    contact.b = other;
    contact.normal = Vec3::UnitY();
    east.game.on_contact(east, contact);
    ASSERT_EQ(east.emitted.size(), 1u);
    EXPECT_GT(east.emitted[0].velocity.y(), 0.0F);
    // The same in the other order: the normal leads from a to b, into the ground.
    std::swap(contact.a, contact.b);
    contact.normal = -Vec3::UnitY();
    east.game.on_contact(east, contact);
    ASSERT_EQ(east.emitted.size(), 2u);
    EXPECT_GT(east.emitted[1].velocity.y(), 0.0F);
}

TEST(Debris, FliesOffWallsThatAreShot) {
    FakeZone zone;
    const EntityId shooter = zone.join(1, Vec3::Zero());
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
    EXPECT_TRUE(zone.emitted.empty()) << "it hit nothing";
    zone.wall_x = 8.0F;
    zone.tick(8);
    zone.command(1, shooter, sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
    ASSERT_EQ(zone.emitted.size(), 1u);
    EXPECT_NEAR(zone.emitted[0].position.x(), 8.0F, 1e-4F);
}

TEST(Debris, IsASettingThatMayBeNone) {
    FakeZone zone(1, Vec3d::Zero(), {{"debris_count", "0"}});
    zone::EntityContact contact;
    contact.a = zone.put(kBall, Vec3::Zero());
    contact.approach_speed = 20.0F;
    zone.game.on_contact(zone, contact);
    EXPECT_TRUE(zone.emitted.empty());
}

TEST(Hail, HurtsWhoStandsInItSomeTimesASecond) {
    FakeZone zone(1, Vec3d::Zero(), {{"hail_system", "hail"}, {"hail_damage", "2"}});
    const EntityId player = zone.join(1, Vec3::Zero());
    zone.tick(16);
    EXPECT_EQ(zone.health(player), 100u) << "nothing falls";
    zone.hail_near = 3;
    zone.tick(16);  // two turns of 3 x 2
    EXPECT_EQ(zone.health(player), 88u);
}

TEST(Hail, IsNotAskedForWithoutTheSetting) {
    FakeZone zone;
    const EntityId player = zone.join(1, Vec3::Zero());
    zone.hail_near = 3;
    zone.tick(16);
    EXPECT_EQ(zone.health(player), 100u);
}

}  // namespace
}  // namespace zoned::rules::test
