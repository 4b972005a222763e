#include "server/app/world/world.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <set>
#include <string>

namespace zoned::app {
namespace {

using scenario::small_world;

/// Every entity is owned by exactly one zone, and no id appeared or vanished.
void expect_one_owner_each(const World& world, const std::set<EntityId>& expected) {
    std::map<EntityId, int> owners;
    for (const auto& zone : world.zones()) {
        const world::Entities& e = zone->state().entities;
        for (world::Row row = 0; row < e.size(); ++row) {
            if (!e.has(row, world::kGhost)) {
                ++owners[e.id[row]];
            }
        }
    }
    ASSERT_EQ(owners.size(), expected.size());
    for (const auto& [id, count] : owners) {
        ASSERT_EQ(count, 1) << "entity " << id.value;
        ASSERT_TRUE(expected.contains(id));
    }
}

/// Ghosts are exactly the neighbours' entities within the margin, at the same place.
void expect_ghosts_match_truth(const World& world, float margin) {
    for (const auto& zone : world.zones()) {
        const zone::ZoneState& own = zone->state();
        std::set<EntityId> expected;
        for (const auto& other : world.zones()) {
            if (other.get() == zone.get()) {
                continue;
            }
            const world::Entities& e = other->state().entities;
            const Vec3d origin = other->state().settings.region().origin();
            for (world::Row row = 0; row < e.size(); ++row) {
                const Vec3d at = origin + e.position[row].cast<double>();
                if (e.has(row, world::kGhost) ||
                    own.settings.region().outside(at.x(), at.z()) > margin) {
                    continue;
                }
                expected.insert(e.id[row]);
                const world::Row ghost = own.entities.find(e.id[row]);
                ASSERT_NE(ghost, world::kNoRow);
                const Vec3d seen =
                    own.settings.region().origin() + own.entities.position[ghost].cast<double>();
                // Two roundings of coordinates below 256 m: half an ulp of 2^-16 m each.
                ASSERT_LT((seen - at).norm(), 4e-5);
            }
        }
        std::set<EntityId> ghosts;
        for (world::Row row = 0; row < own.entities.size(); ++row) {
            if (own.entities.has(row, world::kGhost)) {
                ghosts.insert(own.entities.id[row]);
            }
        }
        ASSERT_EQ(ghosts, expected);
    }
}

mailbox::Input walk(ClientId client, Tick tick, core::Rng& rng, int& heading) {
    if (rng.below(20) == 0) {
        heading = static_cast<int>(rng.below(8));
    }
    static constexpr int kX[8] = {127, 90, 0, -90, -127, -90, 0, 90};
    static constexpr int kZ[8] = {0, 90, 127, 90, 0, -90, -127, -90};
    mailbox::Input input;
    input.client = client;
    motion::InputCommand command;
    command.tick = tick;
    command.move_x = static_cast<std::int8_t>(kX[heading]);
    command.move_z = static_cast<std::int8_t>(kZ[heading]);
    command.buttons = motion::kButtonSprint;
    input.commands.push_back(command);
    return input;
}

TEST(Handoff, LosesAndDoublesNobodyInRandomWalksOverBorders) {
    plain_log() = std::make_shared<scenario::PlainLog>();
    // Zones of 8 m and a hysteresis of 0.1 m: a runner at 8 m/s crosses a border about once a
    // second.
    config::Settings settings = small_world(4, 4, 8.0);
    settings.handoff_hysteresis_m = 0.1F;
    settings.ghost_margin_m = 3.0F;
    for (world::EntityType& type : settings.types) {
        type.aura_m.fill(2.5F);
        type.nimbus_m.fill(2.5F);
    }
    constexpr int kClients = 300;
    // ZONED_HANDOFFS asks for more crossings than a test has time for.
    const char* asked = std::getenv("ZONED_HANDOFFS");
    const std::uint64_t wanted = asked != nullptr ? std::stoull(asked) : 10'000;
    World world(settings, 1);
    std::vector<mailbox::InboxItem> items;
    std::vector<mailbox::OutboxItem> out;
    for (int i = 1; i <= kClients; ++i) {
        mailbox::Join join;
        join.client = ClientId(static_cast<std::uint32_t>(i));
        join.rights = mailbox::kRightPlay;
        items.emplace_back(join);
    }
    world.tick(items, out);
    std::set<EntityId> expected;
    for (const auto& [client, avatar] : plain_log()->avatars) {
        expected.insert(avatar);
    }
    ASSERT_EQ(expected.size(), static_cast<std::size_t>(kClients));

    core::Rng rng(7);
    std::vector<int> headings(kClients, 0);
    std::map<ClientId, std::uint64_t> last_sequence;
    while (world.handoffs() < wanted && world.now() < static_cast<Tick>(wanted)) {
        items.clear();
        out.clear();
        for (const auto& [client, sequence] : last_sequence) {
            items.emplace_back(mailbox::Acks{client, sequence, 0xFFFFFFFFU, 1000});
        }
        for (int i = 0; i < kClients; ++i) {
            items.emplace_back(walk(ClientId(static_cast<std::uint32_t>(i + 1)),
                                    world.now() + 1,
                                    rng,
                                    headings[static_cast<std::size_t>(i)]));
        }
        world.tick(items, out);
        for (const mailbox::OutboxItem& item : out) {
            if (const auto* packet = std::get_if<mailbox::StatePacket>(&item)) {
                // A sequence must never come twice: it is the nonce of the packet's seal.
                ASSERT_GT(packet->sequence, last_sequence[packet->client]);
                last_sequence[packet->client] = packet->sequence;
            }
        }
        if (world.now() % 50 == 0) {
            ASSERT_NO_FATAL_FAILURE(expect_one_owner_each(world, expected));
            ASSERT_NO_FATAL_FAILURE(expect_ghosts_match_truth(world, settings.ghost_margin_m));
        }
    }
    expect_one_owner_each(world, expected);
    EXPECT_GE(world.handoffs(), wanted);
    EXPECT_EQ(world.client_handoffs(), world.handoffs());
    EXPECT_EQ(world.undeliverable(), 0u);
}

TEST(Ghosts, ReachBeyondNeighboursThatAreNarrowerThanTheMargin) {
    plain_log() = std::make_shared<scenario::PlainLog>();
    // Six zones of 8 m in a row, a margin over two of them and a bit.
    config::Settings settings = small_world(6, 1, 8.0);
    settings.ghost_margin_m = 20.0F;
    settings.handoff_hysteresis_m = 0.1F;
    for (int i = 0; i < 40; ++i) {
        config::InitialEntity ball;
        ball.type = scenario::kBall;
        ball.position = Vec3d(-23.0 + 1.15 * i, 3.0 + 0.2 * (i % 5), 0.6 * (i % 7) - 2.0);
        settings.initial.push_back(ball);
    }
    World world(settings, 1);
    std::vector<mailbox::OutboxItem> out;
    for (int t = 0; t < 90; ++t) {
        world.tick({}, out);
        ASSERT_NO_FATAL_FAILURE(expect_ghosts_match_truth(world, settings.ghost_margin_m)) << t;
    }
}

TEST(Handoff, GivesTheSameHashForOneTwoAndFourThreads) {
    std::vector<std::uint64_t> hashes;
    for (const unsigned threads : {1u, 2u, 4u}) {
        config::Settings settings = small_world(2, 2, 60.0);
        for (int i = 0; i < 40; ++i) {
            config::InitialEntity crate;
            crate.type = i % 2 == 0 ? scenario::kCrate : scenario::kBall;
            crate.position = Vec3d(-20.0 + i, 2.0 + 0.1 * i, 3.0 * (i % 7) - 10.0);
            settings.initial.push_back(crate);
        }
        World world(settings, threads);
        std::vector<mailbox::OutboxItem> out;
        std::vector<mailbox::InboxItem> items{
            mailbox::Join{ClientId(1), "a", "", 1, {}, "", false},
            mailbox::Join{ClientId(2), "b", "", 1, {}, "", false}};
        core::Rng rng(3);
        int heading = 0;
        for (int t = 0; t < 600; ++t) {
            world.tick(items, out);
            out.clear();
            items.clear();
            items.emplace_back(walk(ClientId(1), world.now() + 1, rng, heading));
            items.emplace_back(walk(ClientId(2), world.now() + 1, rng, heading));
        }
        hashes.push_back(world.state_hash());
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
}

/// Columns that never change are part of the state too.
TEST(StateHash, KnowsWhatAWorldBeginsWithAtRest) {
    std::set<std::uint64_t> hashes;
    for (const double x : {-5.0, 5.0}) {
        config::Settings settings = small_world(1, 1, 60.0);
        config::InitialEntity crate;
        crate.type = scenario::kCrate;
        crate.position = Vec3d(x, 0.4, 0.0);
        crate.asleep = true;
        settings.initial.push_back(crate);
        World world(settings, 1);
        std::vector<mailbox::OutboxItem> out;
        for (int t = 0; t < 30; ++t) {
            world.tick({}, out);
        }
        hashes.insert(world.state_hash());
    }
    EXPECT_EQ(hashes.size(), 2U);
}

}  // namespace
}  // namespace zoned::app
