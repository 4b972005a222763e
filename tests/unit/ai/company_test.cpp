// Company: following, escorting and guarding against traces worked out by hand.
#include "server/ai/steering/steering.h"
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <optional>

namespace zoned::ai::test {
namespace {

Brain company(ActionKind action, float radius_m) {
    Brain brain = single(action, radius_m);
    brain.perception.given = true;
    brain.perception_m = 60.0F;
    return brain;
}

TEST(Follow, SetsOutBeyondTheRadiusAndStopsWellWithin) {
    Field field;
    field.settings.brains = {company(ActionKind::kFollow, 5.0F)};
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    field.add_player(2, Vec3(0.0F, 0.0F, 4.9F));
    field.run(1.0F);
    EXPECT_EQ(field.position(1), Vec3::Zero()) << "within the radius already";
    field.position(2) = Vec3(0.0F, 0.0F, 8.0F);
    field.step();
    // 4 m/s at 30 Hz: 0.1333 m a tick. From 8 m to 3.5 m apart, 0.7 of the radius, are 33.75 of
    // them.
    int ticks = 0;
    while (field.command(1).move_z != 0 && ticks < 100) {
        field.step();
        ++ticks;
    }
    EXPECT_EQ(ticks, 34);
    EXPECT_LT(field.distance(1, 2), 3.5F);
    EXPECT_GT(field.distance(1, 2), 3.5F - 4.0F * kDt);
    field.run(2.0F);
    EXPECT_EQ(field.command(1).move_z, 0);
}

TEST(Follow, KeepsUpWithALeaderOfItsOwnChoiceAndLeavesOthersAlone) {
    Field field;
    Brain brain = company(ActionKind::kFollow, 4.0F);
    brain.perception.wards = {kSheep};
    field.settings.brains = {brain, single(ActionKind::kIdle)};
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    field.add_npc(3, kSheep, 1, Vec3(0.0F, 0.0F, 3.0F));
    field.add_player(2, Vec3(10.0F, 0.0F, 0.0F));
    for (int t = 0; t < 300; ++t) {
        field.position(3).z() += 2.0F * kDt;
        field.step();
        // Seen every 0.2 s, followed at twice its speed: it is never left far behind.
        EXPECT_LT(field.distance(1, 3), 4.0F + 2.0F * 0.2F + 0.3F);
    }
    EXPECT_GT(field.position(1).z(), 15.0F);
    EXPECT_NEAR(field.position(1).x(), 0.0F, 0.5F);
}

TEST(Escort, GoesBetweenItsWardAndAThreat) {
    const Vec2 here(5.0F, 1.0F);
    const Vec2 ward(0.0F, 0.0F);
    const Vec2 still = Vec2::Zero();
    const auto near = [](const Vec2& a, const Vec2& b) {
        return (a - b).norm() < 1e-5F;
    };
    EXPECT_TRUE(near(escort_place(here, ward, still, Vec2(10.0F, 0.0F), 3.0F), Vec2(3.0F, 0.0F)));
    EXPECT_TRUE(near(escort_place(here, ward, still, Vec2(0.0F, -4.0F), 3.0F), Vec2(0.0F, -2.0F)))
        << "not beyond half way";
    EXPECT_TRUE(near(escort_place(here, ward, still, Vec2(6.0F, 8.0F), 3.0F), Vec2(1.8F, 2.4F)));
}

TEST(Escort, StaysBesideAWardThatMoves) {
    const Vec2 ward(1.0F, 0.0F);
    const Vec2 north(0.0F, 2.0F);
    const auto near = [](const Vec2& a, const Vec2& b) {
        return (a - b).norm() < 1e-5F;
    };
    EXPECT_TRUE(near(escort_place(Vec2(6.0F, 1.0F), ward, north, {}, 3.0F), Vec2(4.0F, 0.0F)));
    EXPECT_TRUE(near(escort_place(Vec2(-4.0F, 1.0F), ward, north, {}, 3.0F), Vec2(-2.0F, 0.0F)));
    // Following one that stands: near enough within 4.5 m, else straight to 3 m.
    EXPECT_TRUE(near(escort_place(Vec2(5.4F, 0.0F), ward, {0, 0}, {}, 3.0F), Vec2(5.4F, 0.0F)));
    EXPECT_TRUE(near(escort_place(Vec2(7.0F, 0.0F), ward, {0, 0}, {}, 3.0F), Vec2(4.0F, 0.0F)));
}

TEST(Escort, WalksToItsPlaceAndMovesWithTheThreat) {
    Field field;
    Brain brain = company(ActionKind::kEscort, 3.0F);
    brain.perception.wards = {kSheep};
    field.settings.brains = {brain, single(ActionKind::kIdle)};
    field.add_npc(1, kGuard, 0, Vec3(0.0F, 0.0F, -8.0F));
    field.add_npc(3, kSheep, 1, Vec3::Zero());
    field.add_player(2, Vec3(12.0F, 0.0F, 0.0F));
    field.run(5.0F);
    EXPECT_LT((field.position(1) - Vec3(3.0F, 0.0F, 0.0F)).norm(), kArriveM);
    field.position(2) = Vec3(0.0F, 0.0F, 12.0F);
    field.run(5.0F);
    EXPECT_LT((field.position(1) - Vec3(0.0F, 0.0F, 3.0F)).norm(), kArriveM);
}

TEST(Guard, EngagesWithinTheRadiusAndReturnsBeyondTheLeash) {
    Field field;
    Brain brain = company(ActionKind::kGuard, 6.0F);
    brain.states[0].leash_m = 10.0F;
    field.settings.brains = {brain};
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    field.add_player(2, Vec3(0.0F, 0.0F, 6.1F));
    field.run(1.0F);
    EXPECT_EQ(field.position(1), Vec3::Zero()) << "nobody comes within 6 m of the post";
    field.position(2).z() = 5.9F;
    field.run(3.0F);
    EXPECT_LT(field.distance(1, 2), kChaseStopM) << "it has run there";
    field.position(2).z() = 9.9F;
    field.run(3.0F);
    EXPECT_LT(field.distance(1, 2), kChaseStopM) << "within the leash it does not let go";
    field.position(2).z() = 10.1F;
    field.run(4.0F);
    EXPECT_LT(field.position(1).norm(), kArriveM) << "beyond it walks home";
    field.position(2).z() = 6.1F;
    field.run(2.0F);
    EXPECT_LT(field.position(1).norm(), kArriveM) << "and a new one must come within 6 m again";
}

TEST(Chase, OfOneThatIsRememberedEndsWhereItWasLast) {
    Field field;
    Brain brain = company(ActionKind::kChase, 5.0F);
    brain.perception_m = 20.0F;
    brain.perception.memory_s = 30.0F;
    field.settings.brains = {brain};
    field.now = 30;
    field.add_npc(1, kGuard, 0, Vec3::Zero());
    field.add_player(2, Vec3(0.0F, 0.0F, 15.0F));
    field.run(0.5F);
    field.position(2) = Vec3(100.0F, 0.0F, 0.0F);
    field.run(8.0F);
    EXPECT_LT((field.position(1) - Vec3(0.0F, 0.0F, 15.0F)).norm(), kChaseStopM);
    EXPECT_EQ(field.agents.find(EntityId(1))->prey, EntityId(2));
}

}  // namespace
}  // namespace zoned::ai::test
