#include "server/rules/peer_messages.h"
#include "tests/unit/rules/fake_zone.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

namespace zoned::rules::test {
namespace {

std::string random_bytes(core::Rng& rng, std::uint32_t most) {
    std::string bytes(rng.below(most + 1), '\0');
    for (char& c : bytes) {
        c = static_cast<char>(rng.next());
    }
    return bytes;
}

/// A valid payload of a random kind.
std::string sample(core::Rng& rng, int kind, EntityId prey) {
    switch (kind) {
        case sandbox::COMMAND_CHAT: {
            sandbox::Chat m;
            m.set_topic("world");
            m.set_text("hello");
            return m.SerializeAsString();
        }
        case sandbox::COMMAND_SHOOT:
            return shot(rng.range(-1.0F, 1.0F), 0.0F, 1.0F).SerializeAsString();
        case sandbox::COMMAND_PICK_UP: {
            sandbox::PickUp m;
            m.set_entity(prey.value);
            return m.SerializeAsString();
        }
        case sandbox::COMMAND_THROW: {
            sandbox::Throw m;
            m.set_item(prey.value);
            m.set_dx(1.0F);
            return m.SerializeAsString();
        }
        case sandbox::COMMAND_PUSH: {
            sandbox::Push m;
            m.set_entity(prey.value);
            return m.SerializeAsString();
        }
        default: {
            sandbox::Subscribe m;
            m.set_topic("world");
            return m.SerializeAsString();
        }
    }
}

TEST(Hostile, CommandsAreDeniedOrCarriedOutAndNeverBreakTheState) {
    FakeZone zone;
    const EntityId player = zone.join(1, Vec3::Zero(), "red");
    const EntityId ball = zone.put(kBall, Vec3(1.0F, 0.0F, 0.0F));
    zone.join(2, Vec3(0.0F, 0.0F, 5.0F));
    core::Rng rng(17);
    for (int i = 0; i < 60000; ++i) {
        const int kind = static_cast<int>(rng.below(8));
        std::string payload = rng.below(4) == 0 ? random_bytes(rng, 64) : sample(rng, kind, ball);
        for (std::uint32_t flips = rng.below(3); flips > 0 && !payload.empty(); --flips) {
            payload[rng.below(static_cast<std::uint32_t>(payload.size()))] =
                static_cast<char>(rng.next());
        }
        zone.raw_command(1, player, kind, payload);
        if (rng.below(20) == 0) {
            zone.tick();
        }
        zone.sent.clear();
    }
    EXPECT_EQ(zone.game.stats().commands, 60000u);
    EXPECT_GT(zone.game.stats().malformed, 1000u);
    EXPECT_GT(zone.game.stats().shots, 100u);
    for (world::Row row = 0; row < zone.entities().size(); ++row) {
        EXPECT_TRUE(zone.entities().position[row].allFinite());
        EXPECT_TRUE(zone.entities().velocity[row].allFinite());
    }
    // Two avatars and one ball, in the world or in the inventory: nothing was made or lost.
    EXPECT_EQ(zone.entities().size() + zone.game.find(player)->inventory.size(), 3u);
}

TEST(Hostile, LongPayloadsAreNotEvenParsed) {
    FakeZone zone;
    const EntityId player = zone.join(1, Vec3::Zero());
    for (int kind = 1; kind <= 6; ++kind) {
        zone.raw_command(1, player, kind, std::string(100000, '\x08'));
    }
    EXPECT_EQ(zone.game.stats().malformed, 6u);
}

TEST(Hostile, UnknownKindsAndForeignAvatarsAreDenied) {
    FakeZone zone;
    const EntityId player = zone.join(1, Vec3::Zero());
    const EntityId other = zone.join(2, Vec3(5.0F, 0.0F, 0.0F));
    zone.raw_command(1, player, 999, "");
    EXPECT_EQ(zone.denial(), "unknown command");
    zone.command(1, other, sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
    EXPECT_EQ(zone.denial(), "no avatar");
    zone.command(1, EntityId(77777), sandbox::COMMAND_SHOOT, shot(1.0F, 0.0F, 0.0F));
    EXPECT_EQ(zone.denial(), "no avatar");
    EXPECT_EQ(zone.game.stats().denied, 3u);
}

TEST(Hostile, MessagesOfOtherZonesThatAreBrokenAreCounted) {
    FakeZone zone;
    const EntityId player = zone.join(1, Vec3::Zero());
    const EntityId ball = zone.put(kBall, Vec3::Zero());
    core::Rng rng(23);
    for (int i = 0; i < 30000; ++i) {
        const std::string bytes = random_bytes(rng, 16);
        zone.game.on_message(zone,
                             rng.below(2) == 0 ? player : ball,
                             {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
        zone.outbox.clear();
        zone.sent.clear();
        if (!zone.exists(ball)) {
            break;
        }
    }
    EXPECT_GT(zone.game.stats().bad_messages, 1000u);
    // Damage to a prop, a grant to an unknown player: readable, but not valid.
    const std::uint64_t missed = zone.game.stats().missed_messages;
    zone.game.on_message(zone, EntityId(9999), encode(Hurt{player, 5}));
    zone.game.on_message(zone, EntityId(9999), encode(PickDone{1}));
    EXPECT_EQ(zone.game.stats().missed_messages, missed + 2);
}

}  // namespace
}  // namespace zoned::rules::test
