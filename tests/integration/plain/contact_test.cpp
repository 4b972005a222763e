// Contacts that rules hear of: beginnings always, lasting ones and ends where they ask for them.
#include "server/app/world/world.h"
#include "server/zone/context/zone_context.h"
#include "tests/integration/plain/plain_log.h"
#include "tests/scenario/small_world.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace zoned::app {
namespace {

/// A crate of 1 m that falls by half a metre onto the ground, in one zone or next to the border
/// of two.
struct Fall {
    World world;
    EntityId crate;

    Fall(zone::ContactWish wish, int zones) : world(with_a_crate(wish, zones), 1) {
        for (const auto& zone : world.zones()) {
            if (zone->state().entities.size() > 0) {
                crate = zone->state().entities.id[0];
            }
        }
    }

    static config::Settings with_a_crate(zone::ContactWish wish, int zones) {
        plain_log() = std::make_shared<scenario::PlainLog>();
        plain_log()->wish = wish;
        config::Settings settings = scenario::small_world(zones, 1, 120.0 / zones);
        config::InitialEntity initial;
        initial.type = scenario::kCrate;
        initial.position = Vec3d(-3.0, 1.0, 0.0);
        settings.initial.push_back(initial);
        return settings;
    }

    void run(int ticks) {
        std::vector<mailbox::OutboxItem> out;
        for (int t = 0; t < ticks; ++t) {
            out.clear();
            world.tick({}, out);
        }
    }

    /// The zone that owns the crate, or null.
    [[nodiscard]] zone::ZoneState* owner() const {
        for (const auto& zone : world.zones()) {
            const world::Entities& e = zone->state().entities;
            const world::Row row = e.find(crate);
            if (row != world::kNoRow && !e.has(row, world::kGhost)) {
                return &zone->state();
            }
        }
        return nullptr;
    }
};

struct Count {
    int began = 0, lasted = 0, ended = 0;
};

Count count() {
    Count c;
    for (const zone::EntityContact& contact : plain_log()->contacts) {
        (contact.began ? c.began : contact.ended ? c.ended : c.lasted) += 1;
        EXPECT_FALSE(contact.began && contact.ended);
    }
    return c;
}

constexpr zone::ContactWish kBoth{true, true};

// The crate weighs 10 kg and lands with 3 m/s: 31 N s, far below the level reported unasked.
TEST(Contacts, TellBeginningsOnlyToRulesThatDoNotAsk) {
    Fall fall({}, 1);
    fall.run(60);
    zone::ZoneContext(*fall.owner()).despawn(fall.crate);
    fall.run(2);
    EXPECT_GE(count().began, 1);
    EXPECT_EQ(count().lasted, 0);
    EXPECT_EQ(count().ended, 0);
}

// A crate at rest presses with m g, in each step until it sleeps.
TEST(Contacts, LastWithTheWeightAsImpulseUntilTheySleep) {
    Fall fall({true, false}, 1);
    fall.run(25);
    ASSERT_FALSE(plain_log()->contacts.empty());
    const zone::EntityContact last = plain_log()->contacts.back();
    EXPECT_FALSE(last.began || last.ended);
    EXPECT_EQ(last.a ? last.a : last.b, fall.crate);
    const zone::ZoneState& zone = *fall.owner();
    EXPECT_NEAR(last.impulse, 10.0F * 9.81F * zone.settings.dt, 0.2F);
    fall.run(120);
    ASSERT_TRUE(zone.entities.has(zone.entities.find(fall.crate), world::kAtRest));
    const int lasted = count().lasted;
    fall.run(10);
    EXPECT_EQ(count().lasted, lasted);
    EXPECT_EQ(count().ended, 0);
}

TEST(Contacts, EndWhenTheEntityLeavesTheGround) {
    Fall fall({false, true}, 1);
    fall.run(25);
    const Count before = count();
    EXPECT_EQ(before.began, before.ended + 1);
    zone::ZoneContext(*fall.owner()).add_velocity(fall.crate, Vec3(0.0F, 5.0F, 0.0F));
    fall.run(5);
    EXPECT_EQ(count().ended, before.ended + 1);
    EXPECT_EQ(count().lasted, 0);
    const zone::EntityContact last = plain_log()->contacts.back();
    EXPECT_TRUE(last.ended);
    EXPECT_EQ(last.a ? last.a : last.b, fall.crate);
}

// The rules hear of it although no entity of that id exists any more.
TEST(Contacts, EndWhenTheEntityIsGone) {
    Fall fall({false, true}, 1);
    fall.run(25);
    const Count before = count();
    zone::ZoneContext context(*fall.owner());
    zone::SpawnDef another;  // keeps physics running
    another.type = scenario::kBall;
    another.position = Vec3(20.0F, 5.0F, 20.0F);
    context.spawn(another);
    context.despawn(fall.crate);
    fall.run(1);
    ASSERT_EQ(count().ended, before.ended + 1);
    EXPECT_EQ(count().began, count().ended);
    EXPECT_EQ(plain_log()->contacts.back().impulse, 0.0F);
    EXPECT_EQ(plain_log()->contacts.back().approach_speed, 0.0F);
}

// It slides over the border: its contact with the ground ends in one zone and begins in the other.
TEST(Contacts, EndAndBeginAgainWithAHandoff) {
    Fall fall({false, true}, 2);
    fall.run(25);
    const Count before = count();
    const zone::ZoneState* from = fall.owner();
    for (int i = 0; i < 60 && fall.owner() == from; ++i) {
        zone::ZoneState& zone = *fall.owner();
        const Vec3 v = zone.entities.velocity[zone.entities.find(fall.crate)];
        zone::ZoneContext(zone).add_velocity(fall.crate, Vec3(6.0F - v.x(), 0.0F, 0.0F));
        fall.run(1);
    }
    ASSERT_NE(fall.owner(), from);
    fall.run(5);
    EXPECT_GT(count().began, before.began);
    EXPECT_GE(count().ended, before.ended + 1);
    EXPECT_EQ(count().began, count().ended + 1);
}

TEST(Contacts, AreMovedByNobodyWhoListens) {
    std::vector<std::uint64_t> hashes[2];
    for (const bool listens : {false, true}) {
        Fall fall(listens ? kBoth : zone::ContactWish{}, 2);
        zone::ZoneContext(*fall.owner()).add_velocity(fall.crate, Vec3(4.0F, 3.0F, 0.5F));
        for (int t = 0; t < 90; ++t) {
            fall.run(1);
            hashes[listens ? 1 : 0].push_back(fall.world.state_hash());
        }
    }
    EXPECT_EQ(hashes[0], hashes[1]);
}

}  // namespace
}  // namespace zoned::app
