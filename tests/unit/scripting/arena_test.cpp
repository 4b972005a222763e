// The shipped example, config/scripts/arena.lua.
#include "tests/unit/scripting/script_zone.h"
#include "proto/sandbox.pb.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string_view>
#include <variant>

namespace zoned::scripting::test {
namespace {

std::string arena_source() {
    std::ostringstream text;
    text << std::ifstream(ZONED_SOURCE_DIR "/config/scripts/arena.lua").rdbuf();
    return text.str();
}

class Arena : public ::testing::Test {
  protected:
    template <class Message>
    void command(std::uint32_t client, EntityId avatar, int kind, const Message& message) {
        zone.command(client, avatar, static_cast<std::uint16_t>(kind), message.SerializeAsString());
    }

    void shoot(int times) {
        sandbox::Shoot shot;
        shot.set_dx(1.0F);
        for (int i = 0; i < times; ++i) {
            command(1, first, sandbox::COMMAND_SHOOT, shot);
            zone.tick(15);
        }
    }

    /// A declared field, as clients get it.
    [[nodiscard]] double number(EntityId entity, std::string_view name) const {
        return std::get<double>(*zone.field(entity, wire::field_id(name)));
    }

    [[nodiscard]] std::string denial() const {
        const auto denials = zone.of_kind(sandbox::EVENT_DENIED);
        return denials.empty() ? "" : FakeContext::parse<sandbox::Denied>(denials.back()).reason();
    }

    void TearDown() override { EXPECT_EQ(zone.errors(), ""); }

    ScriptZone zone{arena_source()};
    EntityId first = zone.join(1, Vec3::Zero());
    EntityId second = zone.join(2, Vec3(10.0F, 0.0F, 0.0F));
};

TEST_F(Arena, KillsAndBringsBack) {
    zone.spawns = {{Vec3d(7.0, 1.0, 3.0), "", ""}};
    shoot(3);
    EXPECT_FALSE(zone.hidden(second));
    EXPECT_EQ(number(second, "health"), 25.0);
    EXPECT_EQ(number(first, "kills"), 0.0);
    shoot(1);
    EXPECT_EQ(number(second, "health"), 0.0);
    EXPECT_EQ(number(first, "kills"), 1.0);
    EXPECT_TRUE(zone.hidden(second));
    EXPECT_EQ(zone.timers.size(), 1u);
    EXPECT_EQ(zone.of_kind(sandbox::EVENT_HIT).size(), 4u);
    ASSERT_EQ(zone.of_kind(sandbox::EVENT_KILL).size(), 1u);
    const auto kill = FakeContext::parse<sandbox::Kill>(zone.of_kind(sandbox::EVENT_KILL)[0]);
    EXPECT_EQ(kill.killer(), first.value);
    EXPECT_EQ(kill.killed(), second.value);
    command(2, second, sandbox::COMMAND_PICK_UP, sandbox::PickUp());
    EXPECT_EQ(denial(), "dead");
    zone.restart();  // a fresh interpreter goes on
    zone.tick(91);
    EXPECT_FALSE(zone.hidden(second));
    EXPECT_EQ(zone.position(second), Vec3(7.0F, 1.0F, 3.0F)) << "at the freest spawn point";
    EXPECT_EQ(number(second, "health"), 100.0);
    EXPECT_EQ(zone.of_kind(sandbox::EVENT_RESPAWN).size(), 1u);
    EXPECT_TRUE(zone.timers.empty());
}

TEST_F(Arena, HealsWhoeverComesToTheWell) {
    shoot(2);
    EXPECT_EQ(number(second, "health"), 50.0);
    zone.rules->on_trigger(zone, {"well", second, false});
    EXPECT_EQ(number(second, "health"), 50.0);
    zone.rules->on_trigger(zone, {"well", second, true});
    EXPECT_EQ(number(second, "health"), 100.0);
}

TEST_F(Arena, LimitsTheRateOfShots) {
    sandbox::Shoot shot;
    shot.set_dx(1.0F);
    command(1, first, sandbox::COMMAND_SHOOT, shot);
    command(1, first, sandbox::COMMAND_SHOOT, shot);
    EXPECT_EQ(denial(), "too fast");
    EXPECT_EQ(zone.of_kind(sandbox::EVENT_HIT).size(), 1u);
}

TEST_F(Arena, HurtsAcrossTheBorderByMessage) {
    ScriptZone other(arena_source(), {}, 2);
    zone.columns().remove(zone.columns().find(second));
    const EntityId theirs = other.join(3, Vec3(10.0F, 0.0F, 0.0F));
    zone.show_ghost(other, theirs);
    shoot(1);
    ASSERT_EQ(zone.outbox.size(), 1u);
    other.rules->on_message(other, theirs, zone.outbox[0].payload);
    ASSERT_EQ(other.of_kind(sandbox::EVENT_HIT).size(), 1u);
    EXPECT_EQ(FakeContext::parse<sandbox::Hit>(other.of_kind(sandbox::EVENT_HIT)[0]).health_left(),
              75u);
}

TEST_F(Arena, PicksUpAndThrows) {
    const EntityId ball = zone.put(kBall, Vec3(0.0F, 0.0F, 1.0F));
    sandbox::PickUp pick;
    pick.set_entity(ball.value);
    command(2, second, sandbox::COMMAND_PICK_UP, pick);
    EXPECT_EQ(denial(), "out of reach");
    command(1, first, sandbox::COMMAND_PICK_UP, pick);
    EXPECT_FALSE(zone.exists(ball));
    const auto inventory =
        FakeContext::parse<sandbox::Inventory>(zone.of_kind(sandbox::EVENT_INVENTORY).back());
    ASSERT_EQ(inventory.items_size(), 1);
    EXPECT_EQ(inventory.items(0), ball.value);
    command(1, first, sandbox::COMMAND_PICK_UP, pick);
    EXPECT_EQ(denial(), "no such thing");
    sandbox::Throw toss;
    toss.set_item(ball.value);
    toss.set_dz(1.0F);
    command(1, first, sandbox::COMMAND_THROW, toss);
    EXPECT_EQ(zone.columns().type[static_cast<world::Row>(zone.columns().size() - 1)], kBall);
    EXPECT_EQ(zone.columns().velocity.back(), Vec3(0.0F, 0.0F, 12.0F));
    command(1, first, sandbox::COMMAND_THROW, toss);
    EXPECT_EQ(denial(), "not in your inventory");
}

TEST_F(Arena, CarriesItsChat) {
    sandbox::Chat chat;
    chat.set_topic("world");
    chat.set_text("hello");
    command(1, first, sandbox::COMMAND_CHAT, chat);
    ASSERT_EQ(zone.of_kind(sandbox::EVENT_CHAT).size(), 1u);
    EXPECT_EQ(FakeContext::parse<sandbox::ChatLine>(zone.of_kind(sandbox::EVENT_CHAT)[0]).text(),
              "hello");
    command(1, first, sandbox::COMMAND_CHAT, chat);
    EXPECT_EQ(denial(), "too fast");
}

TEST_F(Arena, SendsWhoeverSaysSoToAnotherWorld) {
    sandbox::Chat chat;
    chat.set_topic("world");
    chat.set_text("/go meadow");
    command(1, first, sandbox::COMMAND_CHAT, chat);
    EXPECT_EQ(zone.travels, (std::vector<std::string>{"1 meadow "}));
    EXPECT_EQ(denial(), "");
    EXPECT_TRUE(zone.of_kind(sandbox::EVENT_CHAT).empty());
    zone.in_cluster = false;
    command(2, second, sandbox::COMMAND_CHAT, chat);
    EXPECT_EQ(denial(), "no way");
}

TEST_F(Arena, DeniesWhatIsMalformed) {
    core::Rng rng(3);
    for (int i = 0; i < 3000; ++i) {
        std::string bytes(rng.below(40), '\0');
        for (char& byte : bytes) {
            byte = static_cast<char>(rng.next());
        }
        zone.command(1, first, static_cast<std::uint16_t>(rng.below(10)), bytes);
        zone.tick();
    }
    EXPECT_EQ(zone.rules->errors(), 0u);
}

}  // namespace
}  // namespace zoned::scripting::test
