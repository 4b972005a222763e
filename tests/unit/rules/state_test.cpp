#include "server/rules/archive.h"
#include "server/rules/peer_messages.h"
#include "tests/unit/rules/fake_zone.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace zoned::rules::test {
namespace {

/// A fight, a throw, a chat and a death, with a chance to interfere before each tick.
template <class Between>
std::uint64_t play(FakeZone& zone, Between&& between) {
    const EntityId first = zone.join(1, Vec3::Zero(), "red");
    const EntityId second = zone.join(2, Vec3(10.0F, 0.0F, 0.0F), "blue");
    const EntityId ball = zone.put(kBall, Vec3(0.0F, 0.0F, 1.0F));
    zone.put(kGuard, Vec3(0.0F, 0.0F, 20.0F));
    core::Rng rng(9);
    sandbox::PickUp pick;
    pick.set_entity(ball.value);
    zone.command(1, first, sandbox::COMMAND_PICK_UP, pick);
    for (int tick = 0; tick < 600; ++tick) {
        between(tick);
        if (tick < 200) {
            zone.command(1,
                         first,
                         sandbox::COMMAND_SHOOT,
                         rng.below(2) == 0 ? shot(1.0F, 0.0F, 0.0F) : shot(0.0F, 0.0F, 1.0F));
        }
        if (tick == 50) {
            sandbox::Throw toss;
            toss.set_item(ball.value);
            toss.set_dx(-1.0F);
            zone.command(1, first, sandbox::COMMAND_THROW, toss);
        }
        if (tick % 7 == 0) {
            sandbox::Chat chat;
            chat.set_topic("team/blue");
            chat.set_text("help");
            zone.command(2, second, sandbox::COMMAND_CHAT, chat);
        }
        zone.tick();
    }
    EXPECT_GE(zone.game.stats().kills, 1u);
    EXPECT_GE(zone.game.stats().respawns, 1u);
    return zone.hash();
}

TEST(State, IsTheSameForTheSameCommands) {
    FakeZone a;
    FakeZone b;
    const auto nothing = [](int) {
    };
    EXPECT_EQ(play(a, nothing), play(b, nothing));
    ASSERT_EQ(a.sent.size(), b.sent.size());
    for (std::size_t i = 0; i < a.sent.size(); ++i) {
        EXPECT_EQ(a.sent[i].event.payload, b.sent[i].event.payload);
    }
}

TEST(State, SurvivesTakeAndLoadInTheMiddleOfEveryFlow) {
    FakeZone a;
    FakeZone b;
    const std::uint64_t expected = play(a, [](int) {});
    // Each entity is taken and loaded before every tick.
    const std::uint64_t moved = play(b, [&](int) {
        const std::vector<EntityId> ids = b.entities().id;
        for (const EntityId id : ids) {
            const bool busy = b.game.busy();
            const zone::Bytes state = b.game.take_entity(id);
            EXPECT_EQ(b.game.find(id), nullptr);
            b.game.load_entity(id, state);
            EXPECT_EQ(b.game.busy(), busy);
        }
    });
    EXPECT_EQ(moved, expected);
    EXPECT_EQ(a.sent.size(), b.sent.size());
    EXPECT_EQ(b.game.stats().bad_states, 0u);
}

/// A killed client in zone a that has not confirmed yet.
struct Dying : ::testing::Test {
    FakeZone a{1};
    FakeZone b{2, Vec3d(100.0, 0.0, 0.0)};
    EntityId shooter = a.join(1, Vec3(20.0F, 0.0F, 0.0F));
    EntityId victim = a.join(2, Vec3(40.0F, 0.0F, 0.0F));
    EventId event;

    void SetUp() override {
        for (int i = 0; i < 5; ++i) {
            a.command(1, shooter, sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
            a.tick(8);
            b.tick(8);
        }
        event = a.of_kind(sandbox::EVENT_KILL).at(0).id;
    }
};

TEST_F(Dying, ConfirmsInTheZoneThatTheClientWasHandedTo) {
    hand_off(a, b, victim);
    EXPECT_FALSE(a.game.busy());
    EXPECT_TRUE(b.game.busy());
    b.game.on_confirm(b, ClientId(2), event);
    EXPECT_TRUE(b.hidden(victim));
    EXPECT_EQ(b.of_kind(sandbox::EVENT_KILL).size(), 1u);
}

TEST_F(Dying, TimesOutInTheZoneThatTheClientWasHandedTo) {
    hand_off(a, b, victim);
    b.tick_seconds(3.0F);
    EXPECT_TRUE(b.hidden(victim));
    EXPECT_EQ(b.game.stats().kills_unconfirmed, 1u);
}

TEST_F(Dying, RespawnsAtTheSamePlaceOfTheWorldSeenFromAnotherZone) {
    a.game.on_confirm(a, ClientId(2), event);
    hand_off(a, b, victim);
    EXPECT_TRUE(b.hidden(victim));
    b.tick_seconds(5.2F);
    EXPECT_FALSE(b.hidden(victim));
    EXPECT_EQ(b.position(victim), Vec3(-60.0F, 0.0F, 0.0F));
    EXPECT_EQ(b.of_kind(sandbox::EVENT_RESPAWN).size(), 1u);
}

TEST_F(Dying, InventoryCooldownsAndRateLimitsTravel) {
    sandbox::PickUp pick;
    pick.set_entity(a.put(kBall, Vec3(20.0F, 0.0F, 0.0F)).value);
    a.command(1, shooter, sandbox::COMMAND_PICK_UP, pick);
    a.command(1, shooter, sandbox::COMMAND_SHOOT, shot(0.0F, 1.0F, 0.0F));
    hand_off(a, b, shooter);
    b.command(1, shooter, sandbox::COMMAND_SHOOT, shot(0.0F, 1.0F, 0.0F));
    EXPECT_EQ(b.denial(), "too fast");
    sandbox::Throw toss;
    toss.set_item(pick.entity());
    toss.set_dz(1.0F);
    b.command(1, shooter, sandbox::COMMAND_THROW, toss);
    EXPECT_EQ(b.game.stats().throws, 1u);
    a.command(1, shooter, sandbox::COMMAND_THROW, toss);
    EXPECT_EQ(a.denial(), "no avatar");
}

TEST(State, IsSmallForWhoHasNothing) {
    FakeZone zone;
    const EntityId guard = zone.put(kGuard, Vec3::Zero());
    const EntityId ball = zone.put(kBall, Vec3::Zero());
    zone.tick();
    // Format, 24 bytes of spawn position, a byte or two per field.
    EXPECT_LE(zone.game.take_entity(guard).size(), 64u);
    EXPECT_TRUE(zone.game.take_entity(ball).empty());
}

TEST(State, RefusesBytesThatAreNoState) {
    FakeZone zone;
    const EntityId player = zone.join(1, Vec3::Zero(), "red");
    const zone::Bytes good = zone.game.take_entity(player);
    std::uint64_t expected = 0;
    for (std::size_t size = 1; size < good.size(); ++size) {
        zone.game.load_entity(player, std::span(good).first(size));
        EXPECT_EQ(zone.game.stats().bad_states, ++expected);
    }
    zone::Bytes longer = good;
    longer.push_back(0);
    zone.game.load_entity(player, longer);
    EXPECT_EQ(zone.game.stats().bad_states, ++expected);
    EXPECT_EQ(zone.game.find(player), nullptr);
    zone.game.load_entity(player, good);
    EXPECT_NE(zone.game.find(player), nullptr);
    core::Rng rng(2);
    for (int i = 0; i < 20000; ++i) {
        zone::Bytes bad = good;
        bad[rng.below(static_cast<std::uint32_t>(bad.size()))] =
            static_cast<std::uint8_t>(rng.next());
        zone.game.load_entity(player, bad);
    }
}

TEST(State, HashSeesEveryField) {
    const auto hash_of = [](const CharacterRecord& record) {
        zone::Bytes bytes{0x13};
        Writer writer(bytes);
        CharacterRecord::fields(writer, record);
        Sandbox game({}, test_types());
        game.load_entity(EntityId(5), bytes);
        EXPECT_NE(game.find(EntityId(5)), nullptr);
        core::StateHash hash;
        game.hash(hash);
        return hash.value();
    };
    const CharacterRecord base;
    std::vector<CharacterRecord> changed(35);
    changed[0].client = ClientId(1);
    changed[1].name = "a";
    changed[2].team = "a";
    changed[3].spawn.y() = 1.0;
    changed[4].health = 1;
    changed[5].life = Life::kDead;
    changed[6].killer = EntityId(1);
    changed[7].kill_event = EventId(1);
    changed[8].life_until = -1;
    changed[9].next_shot = 1;
    changed[10].next_throw = 1;
    changed[11].next_push = 1;
    changed[12].next_bite = 1;
    changed[13].chat_due = 1;
    changed[14].denial_due = 1;
    changed[15].moved_at = 1;
    changed[16].inventory = {{EntityId(3), 2, 1, {}}};
    changed[17].shots.resize(1);
    changed[18].deaths = 1;
    changed[19].kills = 1;
    changed[20].trades = 1;
    changed[21].ledger_serial = 1;
    changed[22].ledger_digest = 1;
    changed[23].ledger_repeats = 1;
    changed[24].ledger_due = 1;
    changed[25].offer_to = EntityId(1);
    changed[26].offer_give = EntityId(1);
    changed[27].offer_want = EntityId(1);
    changed[28].offer_until = 1;
    changed[29].trade_event = EventId(1);
    changed[30].killer_event = EventId(1);
    changed[31].account = "a";
    changed[32].keeping = Keeping::kKept;
    changed[33].keep_due = true;
    changed[34].strange_items = {{"a", 1, {{"charge", "0.5"}}}};
    for (std::size_t i = 0; i < changed.size(); ++i) {
        EXPECT_NE(hash_of(changed[i]), hash_of(base)) << i;
    }
}

TEST(PeerMessages, RoundTripAndRefuseAllElse) {
    const std::vector<PeerMessage> messages = {
        Hurt{EntityId(70000), 20},
        Knock{Vec3(1.0F, -2.0F, 3.0F)},
        PickRequest{EntityId(9)},
        PickGrant{{EntityId(9), 3, 65535, {{"label", "of Ann"}}}},
        PickRefusal{EntityId(9)},
        PickDone{1}};
    for (const PeerMessage& message : messages) {
        const zone::Bytes bytes = encode(message);
        const std::optional<PeerMessage> back = decode(bytes);
        ASSERT_TRUE(back);
        EXPECT_EQ(encode(*back), bytes);
        for (std::size_t size = 0; size < bytes.size(); ++size) {
            EXPECT_FALSE(decode(std::span(bytes).first(size)));
        }
    }
    EXPECT_FALSE(decode(encode(Knock{Vec3(std::nanf(""), 0.0F, 0.0F)})));
    EXPECT_FALSE(decode(std::vector<std::uint8_t>{200, 0}));
}

TEST(Settings, NameTheMistake) {
    const auto message = [](const zone::RulesSettings& settings) -> std::string {
        try {
            zone::make_rules(settings, test_types());
        } catch (const std::runtime_error& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(message({{"health", "250"}, {"player_type", "guard"}}), "");
    EXPECT_THAT(message({{"healht", "250"}}), ::testing::HasSubstr("healht"));
    EXPECT_THAT(message({{"health", "lots"}}), ::testing::HasSubstr("not a number"));
    EXPECT_THAT(message({{"health", "1 "}}), ::testing::HasSubstr("not a number"));
    EXPECT_THAT(message({{"health", "nan"}}), ::testing::HasSubstr("not a number"));
    EXPECT_THAT(message({{"health", "0"}}), ::testing::HasSubstr("not in ["));
    EXPECT_THAT(message({{"player_type", "wizard"}}), ::testing::HasSubstr("wizard"));
    EXPECT_THAT(message({{"player_type", "ball"}}), ::testing::HasSubstr("not a character"));
}

}  // namespace
}  // namespace zoned::rules::test
