#include "tests/unit/rules/fake_zone.h"
#include "shared/core/utf8.h"

#include <gtest/gtest.h>

namespace zoned::rules::test {
namespace {

using ::testing::Test;

sandbox::Chat line(const std::string& topic, const std::string& text) {
    sandbox::Chat chat;
    chat.set_topic(topic);
    chat.set_text(text);
    return chat;
}

struct Chatting : Test {
    FakeZone zone{3};
    EntityId player = zone.join(1, Vec3::Zero(), "red");

    void say(const std::string& topic, const std::string& text) {
        zone.command(1, player, sandbox::COMMAND_CHAT, line(topic, text));
    }

    [[nodiscard]] std::size_t lines() const { return zone.of_kind(sandbox::EVENT_CHAT).size(); }
};

TEST_F(Chatting, JoinSubscribesAndTellsTheWorld) {
    EXPECT_EQ(zone.topics, (std::vector<std::string>{"+1 world", "+1 team/red"}));
    const std::vector<Sent> joins = zone.of_kind(sandbox::EVENT_JOIN);
    ASSERT_EQ(joins.size(), 1u);
    EXPECT_EQ(joins[0].topic, "world");
    const auto name = FakeZone::parse<sandbox::PlayerName>(joins[0]);
    EXPECT_EQ(name.client(), 1u);
    EXPECT_EQ(name.avatar(), player.value);
    EXPECT_EQ(name.name(), "name1");
    EXPECT_EQ(zone.entities().client[zone.entities().find(player)], ClientId(1));
}

TEST_F(Chatting, LeaveTellsTheWorldAndTakesTheAvatarAway) {
    zone.game.on_leave(zone, ClientId(1), player);
    const std::vector<Sent> leaves = zone.of_kind(sandbox::EVENT_LEAVE);
    ASSERT_EQ(leaves.size(), 1u);
    EXPECT_EQ(leaves[0].topic, "world");
    EXPECT_EQ(FakeZone::parse<sandbox::PlayerName>(leaves[0]).name(), "name1");
    EXPECT_FALSE(zone.exists(player));
    zone.command(1, player, sandbox::COMMAND_CHAT, line("world", "still here?"));
    EXPECT_EQ(zone.denial(), "no avatar");
}

TEST_F(Chatting, ReachesTheWorldTheOwnTeamAndTheOwnZone) {
    for (const char* topic : {"world", "team/red", "zone/3"}) {
        say(topic, "grüße");
        const Sent last = zone.of_kind(sandbox::EVENT_CHAT).back();
        EXPECT_EQ(last.topic, topic);
        const auto chat = FakeZone::parse<sandbox::ChatLine>(last);
        EXPECT_EQ(chat.text(), "grüße");
        EXPECT_EQ(chat.name(), "name1");
        EXPECT_EQ(chat.client(), 1u);
    }
}

TEST_F(Chatting, IsDeniedOnTopicsOfOthers) {
    for (const char* topic : {"team/blue", "zone/2", "zone/33", "", "team/", "World"}) {
        say(topic, "hello");
        EXPECT_EQ(zone.denial(), "not your topic") << topic;
    }
    EXPECT_EQ(lines(), 0u);
    const EntityId loner = zone.join(2, Vec3::Zero());
    zone.command(2, loner, sandbox::COMMAND_CHAT, line("team/", "hello"));
    EXPECT_EQ(lines(), 0u);
}

TEST_F(Chatting, AllowsFiveLinesAtOnceAndThenTwoASecond) {
    for (int i = 0; i < 6; ++i) {
        say("world", "spam");
    }
    EXPECT_EQ(lines(), 5u);
    EXPECT_EQ(zone.denial(), "too fast");
    zone.tick(14);
    say("world", "early");
    EXPECT_EQ(lines(), 5u);
    zone.tick(1);
    say("world", "half a second later");
    EXPECT_EQ(lines(), 6u);
    // In the long run the rate holds, however often one tries.
    for (int tick = 0; tick < 3000; ++tick) {
        say("world", "again");
        zone.tick();
    }
    // Due after 15, 30, ..., 2985 ticks.
    EXPECT_EQ(lines(), 6u + 199u);
}

TEST_F(Chatting, RefusesTextThatIsEmptyTooLongOrNotText) {
    say("world", "");
    say("world", std::string(201, 'x'));
    say("world", "red \x1b[31m");
    zone.raw_command(
        1, player, sandbox::COMMAND_CHAT, std::string("\x0a\x05world\x12\x02\xc3\x28"));
    EXPECT_EQ(zone.game.stats().malformed, 4u);
    EXPECT_EQ(lines(), 0u);
    say("world", std::string(200, 'x'));
    EXPECT_EQ(lines(), 1u);
}

TEST(Utf8, TellsTextFromOtherBytes) {
    for (const char* good :
         {"", "plain", "gr\xc3\xbc\xc3\x9f", "\xe2\x82\xac", "\xf0\x9f\x98\x80"}) {
        EXPECT_TRUE(core::is_clean_utf8(good)) << good;
    }
    // Control characters (also the C1 set), a lone continuation, a cut sequence, overlong forms, a
    // surrogate, beyond U+10FFFF, a byte that never occurs.
    for (const char* bad : {"\x1b[31m",
                            "\x7f",
                            "\xc2\x85",
                            "\x80",
                            "\xe2\x82",
                            "\xc0\xaf",
                            "\xe0\x80\xaf",
                            "\xed\xa0\x80",
                            "\xf4\x90\x80\x80",
                            "\xff"}) {
        EXPECT_FALSE(core::is_clean_utf8(bad)) << bad;
    }
    EXPECT_FALSE(core::is_clean_utf8(std::string_view("\0", 1)));
}

TEST_F(Chatting, SubscribesToTheWorldAndTheOwnTeamOnly) {
    zone.topics.clear();
    sandbox::Subscribe message;
    message.set_topic("world");
    zone.command(1, player, sandbox::COMMAND_SUBSCRIBE, message);
    message.set_topic("team/red");
    message.set_on(true);
    zone.command(1, player, sandbox::COMMAND_SUBSCRIBE, message);
    EXPECT_EQ(zone.topics, (std::vector<std::string>{"-1 world", "+1 team/red"}));
    for (const char* topic : {"team/blue", "zone/1", "zone/3"}) {
        message.set_topic(topic);
        zone.command(1, player, sandbox::COMMAND_SUBSCRIBE, message);
        EXPECT_EQ(zone.denial(), "not your topic");
    }
    EXPECT_EQ(zone.topics.size(), 2u);
}

TEST_F(Chatting, AnswersOnlySoManyDenials) {
    for (int i = 0; i < 100; ++i) {
        say("team/blue", "hello");
    }
    EXPECT_EQ(zone.game.stats().denied, 100u);
    EXPECT_EQ(zone.of_kind(sandbox::EVENT_DENIED).size(), 20u);
    EXPECT_EQ(zone.game.stats().denials_muted, 80u);
}

TEST_F(Chatting, StanceFollowsTheInput) {
    const world::Row row = zone.entities().find(player);
    const auto stance = [&] {
        return static_cast<int>(zone.entities().stance[row]);
    };
    motion::InputCommand command;
    command.move_x = 100;
    zone.game.on_input(zone, player, command, 0);
    EXPECT_EQ(stance(), static_cast<int>(world::Stance::kNormal));
    command.buttons = motion::kButtonSprint;
    zone.game.on_input(zone, player, command, 0);
    EXPECT_EQ(stance(), static_cast<int>(world::Stance::kRunning));
    command.move_x = 0;
    for (int tick = 0; tick < 29; ++tick) {
        zone.tick();
        zone.game.on_input(zone, player, command, 0);
        EXPECT_EQ(stance(), static_cast<int>(world::Stance::kNormal));
    }
    zone.tick();
    zone.game.on_input(zone, player, command, 0);
    EXPECT_EQ(stance(), static_cast<int>(world::Stance::kIdle));
}

TEST_F(Chatting, SneaksAndLooksFarWhereTheWorldHasThoseStances) {
    const world::Row row = zone.entities().find(player);
    const auto after = [&](int move_x, int buttons) {
        motion::InputCommand command;
        command.move_x = static_cast<std::int8_t>(move_x);
        command.buttons = static_cast<std::uint16_t>(buttons);
        zone.tick();
        zone.game.on_input(zone, player, command, 0);
        return static_cast<int>(zone.entities().stance[row]);
    };
    constexpr int kNormal = static_cast<int>(world::Stance::kNormal);
    constexpr int kRunning = static_cast<int>(world::Stance::kRunning);
    constexpr int kSprint = motion::kButtonSprint;
    EXPECT_EQ(after(60, sandbox::BUTTON_SNEAK), kNormal);
    EXPECT_EQ(after(60, sandbox::BUTTON_SPYGLASS), kNormal);
    zone.stances = {"spyglass", "sneaking"};
    const int spyglass = world::kFirstNamedStance;
    const int sneaking = world::kFirstNamedStance + 1;
    EXPECT_EQ(after(60, sandbox::BUTTON_SNEAK), sneaking);
    EXPECT_EQ(after(65, sandbox::BUTTON_SNEAK), kNormal) << "too fast to go unheard";
    EXPECT_EQ(after(0, sandbox::BUTTON_SNEAK), sneaking);
    EXPECT_EQ(after(100, sandbox::BUTTON_SPYGLASS), spyglass);
    EXPECT_EQ(after(0, sandbox::BUTTON_SPYGLASS | sandbox::BUTTON_SNEAK), spyglass);
    EXPECT_EQ(after(60, kSprint | sandbox::BUTTON_SPYGLASS), kRunning);
    EXPECT_EQ(after(60, kSprint | sandbox::BUTTON_SNEAK), kRunning);
}

}  // namespace
}  // namespace zoned::rules::test
