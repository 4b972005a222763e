#include "server/world/entities.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <iterator>
#include <map>

namespace zoned::world {
namespace {

/// Writes values into every column that identify the entity and its version.
void mark(Entities& entities, Row row, std::uint32_t tag) {
    const float f = static_cast<float>(tag);
    entities.set(row, kAtRest, (tag & 1u) != 0);
    entities.position[row] = Vec3(f, f + 1, f + 2);
    entities.orientation[row] = Quat(f, f + 1, f + 2, f + 3);
    entities.velocity[row] = Vec3(f + 3, f + 4, f + 5);
    entities.angular_velocity[row] = Vec3(f + 6, f + 7, f + 8);
    entities.acceleration[row] = Vec3(f + 9, f + 10, f + 11);
    entities.yaw[row] = static_cast<std::uint16_t>(tag);
    entities.appearance[row] = static_cast<std::uint16_t>(tag + 1);
    entities.stance[row] = static_cast<std::uint8_t>(tag);
    entities.body[row] = BodyId(tag + 2);
    entities.set_client(row, ClientId(tag + 3));
    entities.command[row].tick = tag;
    entities.discontinuity_tick[row] = tag + 4;
}

void expect_marked(const Entities& entities, Row row, std::uint32_t tag) {
    const float f = static_cast<float>(tag);
    ASSERT_EQ(entities.has(row, kAtRest), (tag & 1u) != 0);
    ASSERT_EQ(entities.position[row], Vec3(f, f + 1, f + 2));
    ASSERT_EQ(entities.orientation[row].coeffs(), Quat(f, f + 1, f + 2, f + 3).coeffs());
    ASSERT_EQ(entities.velocity[row], Vec3(f + 3, f + 4, f + 5));
    ASSERT_EQ(entities.angular_velocity[row], Vec3(f + 6, f + 7, f + 8));
    ASSERT_EQ(entities.acceleration[row], Vec3(f + 9, f + 10, f + 11));
    ASSERT_EQ(entities.yaw[row], static_cast<std::uint16_t>(tag));
    ASSERT_EQ(entities.appearance[row], static_cast<std::uint16_t>(tag + 1));
    ASSERT_EQ(entities.stance[row], static_cast<std::uint8_t>(tag));
    ASSERT_EQ(entities.body[row], BodyId(tag + 2));
    ASSERT_EQ(entities.client[row], ClientId(tag + 3));
    ASSERT_EQ(entities.command[row].tick, tag);
    ASSERT_EQ(entities.discontinuity_tick[row], tag + 4);
}

void expect_columns_of_one_length(const Entities& e) {
    const std::size_t n = e.size();
    ASSERT_EQ(e.type.size(), n);
    ASSERT_EQ(e.flags.size(), n);
    ASSERT_EQ(e.position.size(), n);
    ASSERT_EQ(e.orientation.size(), n);
    ASSERT_EQ(e.velocity.size(), n);
    ASSERT_EQ(e.angular_velocity.size(), n);
    ASSERT_EQ(e.acceleration.size(), n);
    ASSERT_EQ(e.yaw.size(), n);
    ASSERT_EQ(e.appearance.size(), n);
    ASSERT_EQ(e.stance.size(), n);
    ASSERT_EQ(e.body.size(), n);
    ASSERT_EQ(e.client.size(), n);
    ASSERT_EQ(e.command.size(), n);
    ASSERT_EQ(e.discontinuity_tick.size(), n);
}

TEST(Entities, BehaveAsAMapUnderRandomAddsAndRemoves) {
    core::Rng rng(1);
    Entities entities;
    std::map<EntityId, std::uint32_t> model;
    std::uint32_t next_id = 1;
    for (int i = 0; i < 20000; ++i) {
        // Grows and shrinks in waves, down to nothing.
        const bool grow = (i / 2000) % 2 == 0 ? rng.below(3) != 0 : rng.below(3) == 0;
        if (grow) {
            const EntityId id(next_id++);
            const Row row = entities.add(id, static_cast<TypeIndex>(id.value % 7));
            ASSERT_EQ(row, entities.size() - 1);
            const std::uint32_t tag = rng.below(60000);
            mark(entities, row, tag);
            model[id] = tag;
        } else if (!model.empty()) {
            const auto victim =
                std::next(model.begin(), rng.below(static_cast<std::uint32_t>(model.size())));
            entities.remove(entities.find(victim->first));
            ASSERT_EQ(entities.find(victim->first), kNoRow);
            model.erase(victim);
        }
        ASSERT_EQ(entities.size(), model.size());
        if (i % 500 == 0) {
            expect_columns_of_one_length(entities);
            for (const auto& [id, tag] : model) {
                const Row row = entities.find(id);
                ASSERT_NE(row, kNoRow);
                ASSERT_EQ(entities.id[row], id);
                ASSERT_EQ(entities.type[row], static_cast<TypeIndex>(id.value % 7));
                expect_marked(entities, row, tag);
            }
        }
    }
}

TEST(Entities, AnAddedRowHasDefaultsEvenWhereARemovedOneStood) {
    Entities entities;
    mark(entities, entities.add(EntityId(1), 0), 77);
    entities.remove(0);
    const Row row = entities.add(EntityId(2), 3);
    EXPECT_EQ(entities.type[row], 3);
    EXPECT_EQ(entities.flags[row], 0);
    EXPECT_EQ(entities.position[row], Vec3(0, 0, 0));
    EXPECT_EQ(entities.orientation[row].coeffs(), Quat::Identity().coeffs());
    EXPECT_EQ(entities.velocity[row], Vec3(0, 0, 0));
    EXPECT_FALSE(static_cast<bool>(entities.body[row]));
    EXPECT_FALSE(static_cast<bool>(entities.client[row]));
    EXPECT_EQ(entities.discontinuity_tick[row], 0);
}

TEST(Entities, FlagsAreSetAndClearedOneByOne) {
    Entities entities;
    const Row row = entities.add(EntityId(1), 0);
    entities.set(row, kGhost, true);
    entities.set(row, kHidden, true);
    entities.set(row, kGhost, false);
    EXPECT_FALSE(entities.has(row, kGhost));
    EXPECT_TRUE(entities.has(row, kHidden));
    EXPECT_FALSE(entities.has(row, kGrounded));
}

TEST(EntitiesDeathTest, StopsOnADoubleOrMissingEntity) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    Entities entities;
    entities.add(EntityId(1), 0);
    EXPECT_DEATH(entities.add(EntityId(1), 0), "an entity has one row in a zone");
    EXPECT_DEATH(entities.add(EntityId(), 0), "an entity has one row in a zone");
    EXPECT_DEATH(entities.remove(1), "a row to remove exists");
}

}  // namespace
}  // namespace zoned::world
