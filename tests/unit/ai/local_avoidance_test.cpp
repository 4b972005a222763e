#include "tests/unit/ai/field.h"
#include "tests/unit/allocation_count.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace zoned::ai::test {
namespace {

constexpr std::uint32_t kMany = 120;

/// Wanderers close to each other: 120 in a square of 16 m, around which they wander 8 m.
void crowd(Field& field, const std::vector<std::uint32_t>& order) {
    field.settings.brains = {single(ActionKind::kWander, 8.0F)};
    field.settings.avoidance.emplace();
    field.settings.avoidance->step_s = kDt;
    for (const std::uint32_t id : order) {
        const Vec3 at(1.6F * static_cast<float>(id % 11), 0.9F, 1.6F * static_cast<float>(id / 11));
        field.add_npc(id, kGuard, 0, at);
        field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
    }
}

std::vector<std::uint32_t> ascending() {
    std::vector<std::uint32_t> order(kMany);
    std::iota(order.begin(), order.end(), 1U);
    return order;
}

TEST(LocalAvoidance, DoesNotDependOnTheOrderOfRows) {
    Field a;
    crowd(a, ascending());
    Field b;
    std::vector<std::uint32_t> order = ascending();
    std::reverse(order.begin(), order.end());
    crowd(b, order);
    std::uint64_t gave_way = 0;
    for (int tick = 0; tick < 300; ++tick) {
        gave_way += a.step().avoidance.gave_way;
        b.step();
        for (std::uint32_t id = 1; id <= kMany; ++id) {
            ASSERT_EQ(a.command(id), b.command(id)) << "tick " << tick << " entity " << id;
        }
    }
    EXPECT_GT(gave_way, 1000U);
}

TEST(LocalAvoidance, AllocatesNothingOnceWarm) {
    Field field;
    crowd(field, ascending());
    // The crowd is densest at the start, where it wanders around its homes.
    for (int tick = 0; tick < 600; ++tick) {
        field.step();
    }
    field.grid.build(field.entities.position, 8.0F);
    std::uint64_t crowded = 0;
    const std::uint64_t before = allocation_count();
    for (int tick = 0; tick < 60; ++tick) {
        crowded += field.step().avoidance.crowded;
    }
    EXPECT_GT(crowded, 0U);
    EXPECT_LE(allocation_count(), before) << "in " << crowded << " that met somebody";
}

TEST(LocalAvoidance, LeavesPlayersAlone) {
    // An agent wants to pass through a standing player: it goes around, and the player keeps
    // standing.
    Field field;
    field.settings.brains = {single(ActionKind::kReturn)};
    field.settings.avoidance.emplace();
    field.settings.avoidance->step_s = kDt;
    field.add_player(9, Vec3(5.0F, 0.9F, 0.0F));
    field.add_npc(1, kGuard, 0, Vec3(10.0F, 0.9F, 0.05F));
    field.entities.set(field.entities.find(EntityId(1)), world::kGrounded, true);
    field.position(1) = Vec3(0.0F, 0.9F, 0.0F);
    float nearest = 1e9F;
    for (int tick = 0; tick < 300; ++tick) {
        field.step();
        nearest = std::min(nearest, field.distance(1, 9));
    }
    EXPECT_EQ(field.position(9), Vec3(5.0F, 0.9F, 0.0F));
    EXPECT_GT(nearest, 0.8F * 0.98F) << "two radii less 2 % of one each";
    EXPECT_GT(field.position(1).x(), 8.0F);
}

}  // namespace
}  // namespace zoned::ai::test
