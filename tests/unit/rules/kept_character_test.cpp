// A player's belongings come back at the next login, and no kept record is overwritten unread.
#include "tests/unit/rules/fake_zone.h"

#include <gtest/gtest.h>

namespace zoned::rules::test {
namespace {

using mailbox::StoreAct;
using mailbox::StoreAnswer;
using mailbox::StoreStatus;

struct Kept : ::testing::Test {
    /// As the store answers the request of that place.
    static void answer(FakeZone& zone,
                       std::size_t place,
                       StoreStatus status,
                       const std::vector<std::uint8_t>& value = {}) {
        const mailbox::StoreRequest request = zone.asked.at(place);
        StoreAnswer out;
        out.number = request.number;
        out.act = request.act;
        out.status = status;
        out.target = request.target;
        out.key = request.key;
        out.value = value;
        zone.game.on_store(zone, out);
    }

    static EntityId take_ball(FakeZone& zone, EntityId player) {
        const EntityId ball = zone.put(kBall, Vec3(1.0F, 0.0F, 0.0F));
        zone.set_field(ball, wire::field_id("title"), std::string_view("of Ann"));
        sandbox::PickUp pick;
        pick.set_entity(ball.value);
        zone.command(1, player, sandbox::COMMAND_PICK_UP, pick);
        return ball;
    }

    static sandbox::KeptCharacter kept(const mailbox::StoreRequest& request) {
        sandbox::KeptCharacter out;
        EXPECT_TRUE(
            out.ParseFromArray(request.value.data(), static_cast<int>(request.value.size())));
        return out;
    }

    FakeZone zone;
    EntityId player = zone.join(1, Vec3::Zero(), "", "ann");
};

TEST_F(Kept, AJoinAsksForThePastAndAChangeIsKept) {
    ASSERT_EQ(zone.asked.size(), 1U);
    EXPECT_EQ(zone.asked[0].act, StoreAct::kGet);
    EXPECT_EQ(zone.asked[0].key.account, "ann");
    EXPECT_EQ(zone.asked[0].key.character, "name1");
    answer(zone, 0, StoreStatus::kAbsent);
    take_ball(zone, player);
    ASSERT_EQ(zone.asked.size(), 2U);
    EXPECT_EQ(zone.asked[1].act, StoreAct::kPut);
    EXPECT_EQ(kept(zone.asked[1]).items_size(), 1);
    EXPECT_TRUE(zone.of_kind(sandbox::EVENT_INVENTORY).back().event.durable);
}

TEST_F(Kept, WhatWasKeptComesBackInAnotherWorldUnderIdsOfItsOwn) {
    answer(zone, 0, StoreStatus::kAbsent);
    take_ball(zone, player);
    const std::vector<std::uint8_t> value = zone.asked[1].value;
    FakeZone next;
    const EntityId again = next.join(1, Vec3::Zero(), "", "ann");
    answer(next, 0, StoreStatus::kDone, value);
    const std::vector<std::uint32_t> items = next.inventory();
    ASSERT_EQ(items.size(), 1U);
    EXPECT_FALSE(next.exists(EntityId(items[0]))) << "it is carried, not in the world";
    EXPECT_NE(items[0], again.value);
    // A thrown one is the prop that it was.
    sandbox::Throw toss;
    toss.set_item(items[0]);
    toss.set_dx(1.0F);
    next.command(1, again, sandbox::COMMAND_THROW, toss);
    const EntityId thrown = next.entities().id.back();
    EXPECT_EQ(next.entities().type[next.entities().find(thrown)], kBall);
    EXPECT_EQ(std::get<std::string_view>(*next.field(thrown, wire::field_id("title"))), "of Ann");
    EXPECT_EQ(kept(next.asked.back()).items_size(), 0);
}

TEST_F(Kept, NothingIsWrittenBeforeThePastIsRead) {
    take_ball(zone, player);
    EXPECT_EQ(zone.asked.size(), 1U) << "its answer is still to come";
    EXPECT_FALSE(zone.of_kind(sandbox::EVENT_INVENTORY).back().event.durable);
    sandbox::KeptCharacter past;
    past.add_items()->set_type(zone.types()[kBall].name);
    past.set_kills(3);
    const std::string bytes = past.SerializeAsString();
    answer(zone, 0, StoreStatus::kDone, {bytes.begin(), bytes.end()});
    EXPECT_EQ(zone.inventory().size(), 2U) << "both";
    ASSERT_EQ(zone.asked.size(), 2U);
    EXPECT_EQ(kept(zone.asked[1]).items_size(), 2);
    EXPECT_EQ(kept(zone.asked[1]).kills(), 3U);
}

TEST_F(Kept, AStoreThatCannotBeReadIsNotOverwritten) {
    answer(zone, 0, StoreStatus::kRefused);
    take_ball(zone, player);
    ASSERT_EQ(zone.asked.size(), 2U);
    EXPECT_EQ(zone.asked[1].act, StoreAct::kGet) << "asked again";
    answer(zone, 1, StoreStatus::kDone, {0xFF, 0xFF, 0xFF});
    EXPECT_EQ(zone.game.stats().bad_states, 1U);
    take_ball(zone, player);
    EXPECT_EQ(zone.asked.back().act, StoreAct::kGet);
}

TEST_F(Kept, OneWhoLeavesTakesAlongWhatIsKeptAndDropsTheRest) {
    answer(zone, 0, StoreStatus::kAbsent);
    take_ball(zone, player);
    const std::size_t before = zone.entities().size();
    zone.game.on_leave(zone, ClientId(1), player);
    EXPECT_EQ(zone.entities().size(), before - 1) << "the avatar alone";

    FakeZone other;
    const EntityId stranger = other.join(1, Vec3::Zero(), "", "bob");
    answer(other, 0, StoreStatus::kAbsent);
    take_ball(other, stranger);
    answer(other, 1, StoreStatus::kRefused);
    const std::size_t then = other.entities().size();
    other.game.on_leave(other, ClientId(1), stranger);
    EXPECT_EQ(other.entities().size(), then) << "the ball lies where the avatar was";
}

TEST_F(Kept, WithoutAnAccountNothingIsAskedOrKept) {
    FakeZone guests;
    const EntityId guest = guests.join(1, Vec3::Zero());
    take_ball(guests, guest);
    EXPECT_TRUE(guests.asked.empty());
    EXPECT_FALSE(guests.of_kind(sandbox::EVENT_INVENTORY).back().event.durable);
}

TEST_F(Kept, AnItemOfATypeThatIsGoneStaysWithItsOwner) {
    sandbox::KeptCharacter past;
    past.add_items()->set_type("lantern of an older world");
    const std::string bytes = past.SerializeAsString();
    answer(zone, 0, StoreStatus::kDone, {bytes.begin(), bytes.end()});
    EXPECT_TRUE(zone.inventory().empty());
    take_ball(zone, player);
    const sandbox::KeptCharacter now = kept(zone.asked.back());
    ASSERT_EQ(now.items_size(), 2);
    EXPECT_EQ(now.items(1).type(), "lantern of an older world");
}

TEST_F(Kept, TheAnswerFindsThePlayerInTheZoneThatItWentTo) {
    FakeZone east(2);
    sandbox::KeptCharacter past;
    past.add_items()->set_type(zone.types()[kBall].name);
    const std::string bytes = past.SerializeAsString();
    hand_off(zone, east, player);
    east.asked = zone.asked;
    answer(east, 0, StoreStatus::kDone, {bytes.begin(), bytes.end()});
    EXPECT_EQ(east.inventory().size(), 1U);
    answer(zone, 0, StoreStatus::kDone, {bytes.begin(), bytes.end()});
    EXPECT_EQ(zone.game.stats().missed_messages, 1U);
}

}  // namespace
}  // namespace zoned::rules::test
