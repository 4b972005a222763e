// Passage: no centre goes through static geometry within a step, however a body turns as it hits.
#include "server/physics/scene/scene.h"
#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/mesh.h"
#include "server/physics/shapes/ranges.h"
#include "tests/unit/physics/physics_test.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

namespace zoned::physics {
namespace {

Quat any_turn(core::Rng& rng) {
    const float w = rng.range(-1, 1);
    const float x = rng.range(-1, 1);
    const float y = rng.range(-1, 1);
    const float z = rng.range(-1, 1);
    return Quat(w, x, y, z).normalized();
}

/// Rods that fly to a wall, 0.1 m thick, whose front is at x = 0. A rod that meets it with an end
/// gets 2.4 v / length of spin: at 500 m/s some 60 rad in a step.
struct Range {
    Scene scene;
    std::vector<BodyId> rods;
    std::uint32_t held_back = 0;

    Range(float speed, std::uint32_t mask) : scene(weightless()) {
        core::Rng rng(7);
        BodyDef wall;
        wall.kind = BodyKind::kStatic;
        wall.shape = Shape::box(Vec3(0.05F, 1.0e4F, 1.0e4F));
        wall.position.x() = 0.05F;
        EXPECT_TRUE(scene.add(wall).ok());
        for (int i = 0; i < 100; ++i) {
            const float z = 4.0F * static_cast<float>(i);
            BodyDef rod;
            rod.shape = Shape::box(Vec3(0.3F, 0.05F, 0.1F));
            rod.position = Vec3(-1.0F - speed * kFrame * rng.unit(), 0.0F, z);
            rod.orientation = any_turn(rng);
            rod.velocity = Vec3(speed, 0.0F, 0.0F);
            rod.filter.mask = mask;
            rods.push_back(*scene.add(rod));
        }
    }

    int passed() {
        for (int i = 0; i < 30; ++i) {
            held_back += scene.step(kFrame).held_back;
        }
        int count = 0;
        for (const BodyId rod : rods) {
            count += scene.state(rod).position.x() > 0.05F ? 1 : 0;
        }
        return count;
    }
};

TEST(Passage, IsClosedToRodsThatTurnWhileTheyHit) {
    for (const float speed : {100.0F, 500.0F, 2000.0F, 9000.0F}) {
        Range range(speed, 0xFFFFFFFFU);
        EXPECT_EQ(range.passed(), 0) << speed;
    }
}

TEST(Passage, IsOpenWhereNothingCollides) {
    Range range(500.0F, 0);
    EXPECT_EQ(range.passed(), 100);
    EXPECT_EQ(range.held_back, 0U);
}

TEST(Passage, IsNotLookedForWhereBodiesAreSlow) {
    Range range(1.0F, 0xFFFFFFFFU);
    EXPECT_EQ(range.passed(), 0);
    EXPECT_EQ(range.held_back, 0U);
}

/// The capsule makes three turns in a step, so that each step sees it in the same pose. Its low end
/// comes up at 430 m/s and more, and needs no contact to get out of the floor.
TEST(Passage, IsClosedToWhatSpinsInTimeWithTheSteps) {
    Scene scene{PhysicsSettings()};
    BodyDef ground;
    ground.kind = BodyKind::kStatic;
    ground.shape = Shape::box(Vec3(10.0F, 1.0F, 10.0F));
    ground.position.y() = -1.0F;
    ASSERT_TRUE(scene.add(ground).ok());
    BodyDef capsule;
    capsule.shape = Shape::capsule(0.4F, 0.2F);
    capsule.position.y() = 0.9F;
    capsule.orientation = Quat(Eigen::AngleAxisf(0.7F, Vec3::UnitZ()));  // the low end at x > 0
    capsule.velocity.y() = -2.0F;
    capsule.angular_velocity.z() = 3.0F * 2.0F * std::numbers::pi_v<float> / kFrame;
    const BodyId id = *scene.add(capsule);
    std::uint32_t held_back = 0;
    for (int i = 0; i < 60; ++i) {
        held_back += scene.step(kFrame).held_back;
        ASSERT_GE(scene.state(id).position.y(), 0.0F) << i;
    }
    EXPECT_GE(held_back, 1U);
}

/// Dumb-bells that fly to the wall of a `Range`. No part of them may get through.
TEST(Passage, IsClosedToThePartsOfCompounds) {
    std::vector<CompoundPart> parts(3);
    parts[0].shape = Shape::box(Vec3(0.3F, 0.02F, 0.02F));
    parts[1].shape = parts[2].shape = Shape::sphere(0.06F);
    parts[1].frame.position.x() = 0.3F;
    parts[2].frame.position = Vec3(-0.3F, 0.05F, 0.0F);
    const auto built = build_compound(parts);
    ASSERT_TRUE(built.ok());
    for (const float speed : {100.0F, 500.0F, 2000.0F}) {
        Range range(speed, 0xFFFFFFFFU);
        for (const BodyId rod : range.rods) {
            ASSERT_TRUE(range.scene.set_shape(rod, Shape::compound(built->compound)).ok());
        }
        EXPECT_EQ(range.passed(), 0) << speed;
    }
}

/// A plate thinner than contacts may yield lies on a mesh, and a box of ten times its mass falls on
/// it.
TEST(Passage, IsClosedToAThinPlateThatIsHitFromAbove) {
    Scene scene{PhysicsSettings()};
    const std::vector<Vec3> corners{{-5, 0, -5}, {5, 0, -5}, {5, 0, 5}, {-5, 0, 5}};
    const std::vector<std::uint32_t> indices{0, 2, 1, 0, 3, 2};
    BodyDef ground;
    ground.kind = BodyKind::kStatic;
    ground.shape = Shape::mesh(build_mesh(corners, indices)->mesh);
    ASSERT_TRUE(scene.add(ground).ok());
    BodyDef plate;
    plate.shape = Shape::box(Vec3(0.3F, 0.001F, 0.2F));
    plate.position.y() = 0.001F;
    const BodyId lower = *scene.add(plate);
    BodyDef box;
    box.shape = Shape::box(Vec3(0.4F, 0.1F, 0.2F));
    box.mass = 10.0F;
    box.position = Vec3(0.2F, 1.5F, -0.1F);
    ASSERT_TRUE(scene.add(box).ok());
    for (int i = 0; i < 120; ++i) {
        scene.step(kFrame);
        ASSERT_GE(scene.state(lower).position.y(), -1.0e-3F) << i;
    }
}

/// An elastic hit, r = 0.05 m off the centre of a rod of 1 kg, with k^2 = (0.12^2 + 0.04^2) / 12.
/// There the rod acts as 1 / (1 + r^2 / k^2) = 0.348 kg. It gets J = 2 m v / (1 + m / 0.348) = 651
/// Ns and r J / I = 24,000 rad/s, more than bodies may have. It goes on at the highest permitted
/// spin, is counted and not stopped.
TEST(Passage, LeavesWhatSpinsTooFastWithTheMostSpin) {
    Scene scene(weightless());
    BodyDef rod;
    rod.shape = Shape::box(Vec3(0.02F, 0.06F, 0.02F));
    rod.mass = 1.0F;
    rod.material.restitution = 1.0F;
    rod.material.friction = 0.0F;
    const BodyId hit = *scene.add(rod);
    BodyDef ball;
    ball.shape = Shape::sphere(0.02F);
    ball.mass = 0.306F;
    ball.material = rod.material;
    ball.position = Vec3(-1.0F, 0.05F, 0.0F);
    ball.velocity = Vec3(2000.0F, 0.0F, 0.0F);
    ASSERT_TRUE(scene.add(ball).ok());
    const StepStats stats = scene.step(kFrame);
    EXPECT_EQ(stats.quarantined, 0U);
    EXPECT_EQ(stats.slowed, 1U);
    const float inv_felt = 1.0F + 0.05F * 0.05F * 12.0F / (0.12F * 0.12F + 0.04F * 0.04F);
    const float impulse = 2.0F * 0.306F * 2000.0F / (1.0F + 0.306F * inv_felt);
    // Each of at most 64 substeps rounds once.
    EXPECT_NEAR(scene.state(hit).velocity.x(), impulse, 64.0F * 0x1p-24F * impulse);
    EXPECT_LE(scene.state(hit).angular_velocity.norm(), kMaxSpin);
    EXPECT_GT(scene.state(hit).angular_velocity.norm(), 0.999F * kMaxSpin);
}

}  // namespace
}  // namespace zoned::physics
