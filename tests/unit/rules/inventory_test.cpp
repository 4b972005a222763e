#include "tests/unit/rules/fake_zone.h"

#include <gtest/gtest.h>

namespace zoned::rules::test {
namespace {

sandbox::PickUp pick(EntityId item) {
    sandbox::PickUp message;
    message.set_entity(item.value);
    return message;
}

sandbox::Throw toss(std::uint32_t item, float dx, float dy, float dz) {
    sandbox::Throw message;
    message.set_item(item);
    message.set_dx(dx);
    message.set_dy(dy);
    message.set_dz(dz);
    return message;
}

struct Hands : ::testing::Test {
    FakeZone zone;
    EntityId player = zone.join(1, Vec3::Zero());

    void pick_up(EntityId item) { zone.command(1, player, sandbox::COMMAND_PICK_UP, pick(item)); }

    EntityId newest() { return zone.entities().id.back(); }
};

TEST_F(Hands, TakePropsOutOfTheWorld) {
    const EntityId ball = zone.put(kBall, Vec3(2.0F, 0.0F, 0.0F));
    pick_up(ball);
    EXPECT_FALSE(zone.exists(ball));
    EXPECT_EQ(zone.inventory(), std::vector<std::uint32_t>{ball.value});
    const std::vector<Sent> picked = zone.of_kind(sandbox::EVENT_PICK_UP);
    ASSERT_EQ(picked.size(), 1u);
    EXPECT_EQ(picked[0].channel, Channel::kViewers);
    EXPECT_EQ(picked[0].source, player);
    EXPECT_EQ(FakeZone::parse<sandbox::PickedUp>(picked[0]).item(), ball.value);
    EXPECT_EQ(zone.of_kind(sandbox::EVENT_INVENTORY).back().client, ClientId(1));
}

TEST_F(Hands, DenyWhatCannotBeCarried) {
    pick_up(zone.put(kCrate, Vec3(1.0F, 0.0F, 0.0F)));
    EXPECT_EQ(zone.denial(), "cannot be carried");  // 50 kg
    pick_up(zone.put(kGuard, Vec3(1.0F, 0.0F, 0.0F)));
    EXPECT_EQ(zone.denial(), "cannot be carried");
    pick_up(zone.put(kBall, Vec3(2.6F, 0.0F, 0.0F)));
    EXPECT_EQ(zone.denial(), "out of reach");
    pick_up(EntityId(4000));
    EXPECT_EQ(zone.denial(), "no such thing");
    pick_up(EntityId(0));
    EXPECT_EQ(zone.denial(), "no such thing");
    const EntityId hidden = zone.put(kBall, Vec3(1.0F, 0.0F, 0.0F));
    zone.hide(hidden);
    pick_up(hidden);
    EXPECT_EQ(zone.denial(), "no such thing");
    const EntityId lost = zone.put(kBall, Vec3(std::nanf(""), 0.0F, 0.0F));
    pick_up(lost);
    EXPECT_EQ(zone.denial(), "out of reach");
    EXPECT_EQ(zone.game.stats().denied, 7u);
    EXPECT_TRUE(zone.inventory().empty());
}

TEST_F(Hands, HoldEightThings) {
    for (int i = 0; i < 9; ++i) {
        pick_up(zone.put(kBall, Vec3(1.0F, 0.0F, 0.0F)));
    }
    EXPECT_EQ(zone.inventory().size(), 8u);
    EXPECT_EQ(zone.denial(), "inventory full");
}

TEST_F(Hands, ThrowAtTwelveMetresPerSecond) {
    const EntityId ball = zone.put(kBall, Vec3(1.0F, 0.0F, 0.0F));
    zone.set_appearance(ball, 7);
    pick_up(ball);
    zone.command(1, player, sandbox::COMMAND_THROW, toss(ball.value, 0.0F, 0.0F, 5.0F));
    EXPECT_TRUE(zone.inventory().empty());
    const world::Row row = zone.entities().find(newest());
    EXPECT_EQ(zone.entities().type[row], kBall);
    EXPECT_EQ(zone.entities().appearance[row], 7);
    EXPECT_EQ(zone.entities().velocity[row], Vec3(0.0F, 0.0F, 12.0F));
    // Clear of the thrower's capsule (radius 0.4) and of the ball's own radius, from the eye.
    EXPECT_GT(zone.entities().position[row].z(), 0.6F);
    EXPECT_FLOAT_EQ(zone.entities().position[row].y(), 0.7F);
}

TEST_F(Hands, KeepWhatTheFieldsOfAThingHold) {
    const EntityId ball = zone.put(kBall, Vec3(1.0F, 0.0F, 0.0F));
    const auto set = [&](std::string_view name, const wire::FieldValue& value) {
        EXPECT_EQ(zone.set_field(ball, wire::field_id(name), value), wire::FieldOutcome::kDone);
    };
    set("kills", 17.0);
    set("mood", std::string_view("angry"));
    set("ready", true);
    set("title", std::string_view("of Ann"));
    const auto expect_all = [&](EntityId thing) {
        const auto value = [&](std::string_view name) {
            return *zone.field(thing, wire::field_id(name));
        };
        EXPECT_EQ(std::get<double>(value("kills")), 17.0);
        EXPECT_EQ(std::get<double>(value("health")), 100.0);
        EXPECT_EQ(std::get<std::string_view>(value("mood")), "angry");
        EXPECT_TRUE(std::get<bool>(value("ready")));
        EXPECT_EQ(std::get<std::string_view>(value("title")), "of Ann");
    };
    pick_up(ball);
    ASSERT_EQ(zone.game.find(player)->inventory.size(), 1u);
    EXPECT_EQ(zone.game.find(player)->inventory[0].held.size(), 4u) << "health is as it begins";
    zone.command(1, player, sandbox::COMMAND_THROW, toss(ball.value, 0.0F, 0.0F, 5.0F));
    expect_all(newest());
    // Dropped, because its carrier leaves.
    zone.position(newest()) = Vec3(1.0F, 0.0F, 0.0F);
    pick_up(newest());
    zone.game.on_leave(zone, ClientId(1), player);
    expect_all(newest());
}

TEST_F(Hands, ThrowDownwardsPastTheirOwnBody) {
    const EntityId ball = zone.put(kBall, Vec3(1.0F, 0.0F, 0.0F));
    pick_up(ball);
    zone.command(1, player, sandbox::COMMAND_THROW, toss(ball.value, 0.0F, -1.0F, 0.0F));
    // The capsule ends 0.9 m below its centre.
    EXPECT_LT(zone.position(newest()).y(), -0.9F - 0.2F);
}

TEST_F(Hands, DenyThrowsOfNothingIntoWallsAndTooFast) {
    const EntityId ball = zone.put(kBall, Vec3(1.0F, 0.0F, 0.0F));
    zone.command(1, player, sandbox::COMMAND_THROW, toss(ball.value, 1.0F, 0.0F, 0.0F));
    EXPECT_EQ(zone.denial(), "not in your inventory");
    pick_up(ball);
    zone.wall_x = 0.5F;
    zone.command(1, player, sandbox::COMMAND_THROW, toss(ball.value, 1.0F, 0.0F, 0.0F));
    EXPECT_EQ(zone.denial(), "no room to throw");
    EXPECT_EQ(zone.game.find(player)->inventory.size(), 1u);
    zone.command(1, player, sandbox::COMMAND_THROW, toss(ball.value, std::nanf(""), 0.0F, 0.0F));
    EXPECT_EQ(zone.denial(), "malformed");
    const EntityId second = zone.put(kBall, Vec3(0.0F, 0.0F, 1.0F));
    pick_up(second);
    zone.command(1, player, sandbox::COMMAND_THROW, toss(ball.value, -1.0F, 0.0F, 0.0F));
    zone.command(1, player, sandbox::COMMAND_THROW, toss(second.value, -1.0F, 0.0F, 0.0F));
    EXPECT_EQ(zone.denial(), "too fast");
    EXPECT_EQ(zone.game.stats().throws, 1u);
}

TEST_F(Hands, DropEverythingWhenTheClientLeaves) {
    for (int i = 0; i < 3; ++i) {
        pick_up(zone.put(kBall, Vec3(1.0F, 0.0F, 0.0F)));
    }
    zone.position(player) = Vec3(30.0F, 0.0F, 0.0F);
    zone.wall_x = 30.3F;  // one place of the ring lies behind a wall
    zone.game.on_leave(zone, ClientId(1), player);
    EXPECT_FALSE(zone.exists(player));
    ASSERT_EQ(zone.entities().size(), 3u);
    for (const Vec3& p : zone.entities().position) {
        EXPECT_LT((p - Vec3(30.0F, 0.0F, 0.0F)).norm(), 1.0F);
        EXPECT_LT(p.x(), 30.3F);
    }
}

TEST_F(Hands, PushPropsAndCharactersThatAreNear) {
    const EntityId crate = zone.put(kCrate, Vec3(0.0F, -0.4F, 1.5F));
    sandbox::Push push;
    push.set_entity(crate.value);
    zone.command(1, player, sandbox::COMMAND_PUSH, push);
    EXPECT_LT((zone.velocity(crate) - Vec3(0.0F, 0.0F, 3.0F)).norm(), 1e-5F);
    zone.command(1, player, sandbox::COMMAND_PUSH, push);
    EXPECT_EQ(zone.denial(), "too fast");
    zone.tick_seconds(0.6F);
    zone.position(crate) = Vec3(0.0F, 0.0F, 2.1F);
    zone.command(1, player, sandbox::COMMAND_PUSH, push);
    EXPECT_EQ(zone.denial(), "out of reach");
    push.set_entity(player.value);
    zone.command(1, player, sandbox::COMMAND_PUSH, push);
    EXPECT_EQ(zone.denial(), "no such thing");
    const EntityId other = zone.join(2, Vec3::Zero());  // on the same spot: along the facing
    push.set_entity(other.value);
    zone.command(1, player, sandbox::COMMAND_PUSH, push);
    EXPECT_LT((zone.velocity(other) - Vec3(0.0F, 0.0F, 3.0F)).norm(), 1e-5F);
}

struct Missile : Hands {
    EntityId victim = zone.join(2, Vec3(5.0F, 0.0F, 0.0F));
    EntityId missile;

    void SetUp() override {
        const EntityId ball = zone.put(kBall, Vec3(-1.0F, 0.0F, 0.0F));
        pick_up(ball);
        zone.command(1, player, sandbox::COMMAND_THROW, toss(ball.value, 1.0F, 0.0F, 0.0F));
        missile = newest();
    }

    [[nodiscard]] zone::EntityContact contact(EntityId a, EntityId b, float speed) const {
        zone::EntityContact c;
        c.a = a;
        c.b = b;
        c.normal = Vec3::UnitX();
        c.impulse = 24.0F;  // 2 kg stopped from 12 m/s
        c.approach_speed = speed;
        c.began = true;
        return c;
    }
};

TEST_F(Missile, HurtsAndKnocksByItsImpulse) {
    zone.game.on_contact(zone, contact(missile, victim, 12.0F));
    EXPECT_EQ(zone.health(victim), 90u);  // 24 N s * 0.4 = 9.6
    EXPECT_NEAR(zone.velocity(victim).x(), 24.0F / 80.0F, 1e-6F);
    const auto hit = FakeZone::parse<sandbox::Hit>(zone.of_kind(sandbox::EVENT_HIT).at(0));
    EXPECT_EQ(hit.shooter(), player.value);
    zone.game.on_contact(zone, contact(missile, victim, 12.0F));  // once only
    EXPECT_EQ(zone.health(victim), 90u);
}

TEST_F(Missile, KnocksAwayWhicheverSideItIsOn) {
    zone::EntityContact c = contact(victim, missile, 12.0F);
    c.normal = -Vec3::UnitX();  // from the victim to the missile
    zone.game.on_contact(zone, c);
    EXPECT_GT(zone.velocity(victim).x(), 0.0F);
    EXPECT_EQ(zone.health(victim), 90u);
}

TEST_F(Missile, SparesTheSlowlyHitTheThrowerAndTheWalls) {
    zone.game.on_contact(zone, contact(missile, victim, 6.0F));
    zone.game.on_contact(zone, contact(missile, player, 12.0F));
    zone.game.on_contact(zone, contact(missile, EntityId(), 12.0F));
    EXPECT_EQ(zone.health(victim), 100u);
    EXPECT_EQ(zone.health(player), 100u);
    zone.game.on_contact(zone, contact(missile, victim, 6.1F));
    EXPECT_EQ(zone.health(victim), 90u);
}

TEST_F(Missile, IsHarmlessAfterFiveSeconds) {
    EXPECT_TRUE(zone.game.busy());
    zone.tick_seconds(5.1F);
    EXPECT_FALSE(zone.game.busy());
    zone.game.on_contact(zone, contact(missile, victim, 12.0F));
    EXPECT_EQ(zone.health(victim), 100u);
}

TEST_F(Missile, StaysDangerousAcrossABorder) {
    FakeZone other(2);
    hand_off(zone, other, missile);
    other.show_ghost(zone, victim);
    EXPECT_FALSE(zone.game.busy());
    EXPECT_TRUE(other.game.busy());
    zone.show_ghost(other, missile);
    zone.game.on_contact(zone, contact(missile, victim, 12.0F));  // not the owner: nothing
    EXPECT_EQ(zone.health(victim), 100u);
    other.game.on_contact(other, contact(missile, victim, 12.0F));
    deliver(zone, other);
    EXPECT_EQ(zone.health(victim), 90u);
    EXPECT_GT(zone.velocity(victim).x(), 0.0F);
}

/// A picker in zone a, a ball in zone b that a sees as a ghost.
struct AcrossTheBorder : ::testing::Test {
    FakeZone a{1};
    FakeZone b{2, Vec3d(100.0, 0.0, 0.0)};
    EntityId picker = a.join(1, Vec3(49.0F, 0.0F, 0.0F));
    EntityId ball = b.put(kBall, Vec3(-49.0F, 0.0F, 0.0F));

    void SetUp() override {
        b.set_appearance(ball, 5);
        a.show_ghost(b, ball);
    }

    void reach() { a.command(1, picker, sandbox::COMMAND_PICK_UP, pick(ball)); }

    /// Carries the messages on their path to `zone`, one step.
    static void carry(FakeZone& from, FakeZone& to) {
        for (const Mail& m : std::exchange(from.outbox, {})) {
            to.game.on_message(to, m.target, m.payload);
        }
    }
};

TEST_F(AcrossTheBorder, PickUpTakesTheItemOnce) {
    reach();
    EXPECT_TRUE(a.inventory().empty());
    deliver(a, b);
    EXPECT_EQ(a.inventory(), std::vector<std::uint32_t>{ball.value});
    EXPECT_EQ(a.game.find(picker)->inventory.at(0).appearance, 5);
    EXPECT_FALSE(b.exists(ball));
    EXPECT_FALSE(b.game.busy());
}

TEST_F(AcrossTheBorder, TheFirstOfTwoPickersGetsIt) {
    const EntityId second = b.join(2, Vec3(-48.0F, 0.0F, 0.0F));
    reach();
    b.command(2, second, sandbox::COMMAND_PICK_UP, pick(ball));
    deliver(a, b);
    EXPECT_EQ(b.inventory(), std::vector<std::uint32_t>{ball.value});
    EXPECT_TRUE(a.inventory().empty());
    // The item is gone and has no owner: the request is lost, as the interface says.
    EXPECT_EQ(a.game.stats().pick_ups + b.game.stats().pick_ups, 1u);
}

TEST_F(AcrossTheBorder, AReservedItemIsRefusedToOthers) {
    const EntityId second = a.join(2, Vec3(49.5F, 0.0F, 0.0F));
    reach();
    a.command(2, second, sandbox::COMMAND_PICK_UP, pick(ball));
    deliver(a, b);
    EXPECT_EQ(a.game.stats().pick_ups, 1u);
    EXPECT_EQ(a.denial(), "no such thing");
    EXPECT_EQ(a.of_kind(sandbox::EVENT_DENIED).back().client, ClientId(2));
}

TEST_F(AcrossTheBorder, TheItemComesBackWhenThePickerIsGone) {
    reach();
    carry(a, b);
    EXPECT_TRUE(b.hidden(ball));
    EXPECT_TRUE(b.game.busy());
    a.game.on_leave(a, ClientId(1), picker);
    b.outbox.clear();  // the picker has no owner: lost
    b.tick_seconds(1.1F);
    EXPECT_FALSE(b.hidden(ball));
    EXPECT_EQ(b.game.stats().pick_ups_returned, 1u);
    EXPECT_FALSE(b.game.busy());
}

TEST_F(AcrossTheBorder, TheItemComesBackWhenTheInventoryIsFull) {
    for (int i = 0; i < 7; ++i) {
        a.command(1, picker, sandbox::COMMAND_PICK_UP, pick(a.put(kBall, Vec3(49.0F, 0.0F, 0.0F))));
    }
    reach();
    carry(a, b);
    a.command(1, picker, sandbox::COMMAND_PICK_UP, pick(a.put(kBall, Vec3(49.0F, 0.0F, 0.0F))));
    deliver(a, b);
    EXPECT_EQ(a.inventory().size(), 8u);
    EXPECT_FALSE(b.hidden(ball));
    EXPECT_EQ(a.denial(), "inventory full");
}

TEST_F(AcrossTheBorder, AReservationTravelsWithTheItem) {
    FakeZone c(3);
    reach();
    carry(a, b);
    hand_off(b, c, ball);
    carry(b, a);
    carry(a, c);
    EXPECT_EQ(a.inventory(), std::vector<std::uint32_t>{ball.value});
    EXPECT_FALSE(c.exists(ball));
}

TEST_F(AcrossTheBorder, PushReachesAGhost) {
    sandbox::Push push;
    push.set_entity(ball.value);
    a.command(1, picker, sandbox::COMMAND_PUSH, push);
    deliver(a, b);
    EXPECT_LT((b.velocity(ball) - Vec3(3.0F, 0.0F, 0.0F)).norm(), 1e-5F);
}

}  // namespace
}  // namespace zoned::rules::test
