// Soft bodies as wholes: pushed, placed, put to sleep, handed from one SoftBodies to another, and
// how they are turned.
#include "tests/unit/soft/soft_test.h"

#include <utility>

namespace zoned::physics::soft {
namespace {

constexpr float kRounding = 2.0e-5F;  // of floats of some metres, a few operations on

SoftDef small_jelly() {
    JellyDef def;
    def.size = Vec3(1.0F, 0.6F, 0.8F);
    def.nodes = {3, 3, 3};
    def.mass = 9.0F;
    return *build_jelly(def);
}

SoftDef held_cloth() {
    ClothDef def;
    def.nx = def.nz = 5;
    def.pins = {{0, 0}, {4, 0}};
    def.coarsen = 1;
    return *build_cloth(def);
}

SoftDef turned(SoftDef def, const Quat& turn, const Vec3& by) {
    for (SoftNode& node : def.nodes) {
        node.position = turn * node.position + by;
    }
    return def;
}

TEST(SoftMoves, APushGivesAllFreeNodesTheVelocityAndNoneToPinnedOnes) {
    SoftBodies bodies(weightless_soft());
    const SoftDef def = held_cloth();
    const SoftId id = put(bodies, def);
    bodies.sleep(id);
    bodies.push(id, Vec3(1.0F, 2.0F, -3.0F));
    EXPECT_FALSE(bodies.asleep(id));
    for (std::size_t i = 0; i < def.nodes.size(); ++i) {
        EXPECT_EQ(bodies.velocity(id, i),
                  def.nodes[i].pinned ? Vec3(Vec3::Zero()) : Vec3(1.0F, 2.0F, -3.0F));
    }
    bodies.push(id, Vec3::Constant(kNan));
    EXPECT_TRUE(bodies.velocity(id, 7).allFinite());
}

TEST(SoftMoves, ABodyThatSleepsStaysAsItIsThoughItsSpringsPull) {
    SoftBodies bodies;
    SoftDef def = small_jelly();
    def.nodes[13].position.x() += 0.1F;
    const SoftId id = put(bodies, def);
    bodies.sleep(id);
    run(bodies, 10);
    EXPECT_TRUE(bodies.stats().skipped);
    EXPECT_EQ(bodies.position(id, 13), def.nodes[13].position);
    bodies.wake(id);
    run(bodies, 1);
    EXPECT_NE(bodies.position(id, 13), def.nodes[13].position);
}

TEST(SoftMoves, APlacedBodyKeepsItsDeformationAndItsPinsHoldThere) {
    SoftBodies bodies(awake_soft());
    const SoftDef def = held_cloth();
    const SoftId id = put(bodies, def);
    run(bodies, 30);
    const Vec3 before = bodies.position(id, 12) - bodies.rigid_hull(id).position;
    const Vec3 pin = bodies.position(id, 0) - bodies.rigid_hull(id).position;
    const Vec3 to(5.0F, 8.0F, -2.0F);
    bodies.place(id, to, Quat::Identity());
    EXPECT_LT((bodies.position(id, 12) - to - before).norm(), kRounding);
    EXPECT_EQ(bodies.velocity(id, 12), Vec3(Vec3::Zero()));
    run(bodies, 30);
    EXPECT_LT((bodies.position(id, 0) - to - pin).norm(), kRounding);
}

TEST(SoftMoves, AHandedBodyGoesOnAsIfItHadStayed) {
    SoftBodies stays(awake_soft());
    SoftBodies leaves(awake_soft());
    SoftBodies takes(awake_soft());
    SoftDef def = held_cloth();
    def.material.tear_force = 0.35F;  // some springs break
    const SoftId there = put(stays, def);
    SoftId id = put(leaves, def);
    run(stays, 40);
    run(leaves, 40);
    ASSERT_LT(stays.spring_count(there), def.springs.size());
    // Nothing is rounded without a shift: the same bits.
    SoftParcel parcel = leaves.take(id);
    EXPECT_TRUE(leaves.empty());
    ASSERT_FALSE(parcel.empty());
    id = takes.give(std::move(parcel), Vec3::Zero());
    run(stays, 40);
    run(takes, 40);
    ASSERT_EQ(takes.node_count(id), stays.node_count(there));
    EXPECT_EQ(takes.spring_count(id), stays.spring_count(there));
    for (std::size_t i = 0; i < takes.node_count(id); ++i) {
        ASSERT_EQ(takes.position(id, i), stays.position(there, i)) << i;
        ASSERT_EQ(takes.velocity(id, i), stays.velocity(there, i)) << i;
    }
}

TEST(SoftMoves, AHandedBodyIsShiftedAndItsPinsToo) {
    SoftBodies from(awake_soft());
    SoftBodies to(awake_soft());
    const SoftDef def = held_cloth();
    const Vec3 shift(-64.0F, 0.0F, 32.0F);
    const SoftId id = to.give(from.take(put(from, def)), shift);
    for (std::size_t i = 0; i < def.nodes.size(); ++i) {
        EXPECT_LT((to.position(id, i) - def.nodes[i].position - shift).norm(), kRounding);
    }
    run(to, 10);
    EXPECT_LT((to.position(id, 0) - def.nodes[0].position - shift).norm(), kRounding);
}

TEST(SoftMoves, TheBestFitOfARigidMotionIsItsTurn) {
    const Quat turn(Eigen::AngleAxisf(2.5F, Vec3(1.0F, -2.0F, 0.5F).normalized()));
    for (const SoftDef& def : {small_jelly(), held_cloth()}) {
        SoftBodies bodies;
        const SoftId id = put(bodies, turned(def, turn, Vec3(3.0F, 4.0F, 5.0F)));
        const Quat found = bodies.best_fit_turn(id, def, Quat::Identity());
        // The search ends below 1e-6 rad; nodes are rounded at 1e-7 of some metres.
        EXPECT_LT(found.angularDistance(turn), 1.0e-5F);
    }
}

TEST(SoftMoves, TheBestFitOfAStretchedBodyIsNotTurned) {
    SoftDef def = small_jelly();
    const SoftDef rest = def;
    for (SoftNode& node : def.nodes) {
        node.position = node.position.cwiseProduct(Vec3(1.5F, 0.7F, 1.1F));
    }
    SoftBodies bodies;
    const SoftId id = put(bodies, def);
    const Quat guess(Eigen::AngleAxisf(0.4F, Vec3::UnitZ()));
    EXPECT_LT(bodies.best_fit_turn(id, rest, guess).angularDistance(Quat::Identity()), 1.0e-5F);
}

TEST(SoftMoves, ARopeThatIsStraightTurnsAsLittleAsItCan) {
    RopeDef rope;
    rope.pin_from = false;
    const SoftDef def = *build_rope(rope);  // along x
    const Quat turn(Eigen::AngleAxisf(0.5F, Vec3::UnitZ()));
    SoftBodies bodies;
    const SoftId id = put(bodies, turned(def, turn, Vec3::Zero()));
    EXPECT_LT(bodies.best_fit_turn(id, def, Quat::Identity()).angularDistance(turn), 1.0e-5F);
}

}  // namespace
}  // namespace zoned::physics::soft
