// Blows by bodies that impulses do not move: as seen by somebody who goes with the mover they are
// blows against something that stands still.
#include "tests/unit/physics/joint_scene.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics {
namespace {

constexpr float kWall_mps = 5.0F;

/// A wall whose face is at x = 0 at the start, and goes along x.
BodyDef wall(const Vec3& velocity) {
    BodyDef def;
    def.kind = BodyKind::kKinematic;
    def.shape = Shape::box(Vec3(0.25F, 4.0F, 4.0F));
    def.position = Vec3(-0.25F, 0.0F, 0.0F);
    def.velocity = velocity;
    return def;
}

BodyDef body_of(const Shape& shape, const Vec3& position, float restitution) {
    BodyDef def;
    def.shape = shape;
    def.mass = 3.0F;
    def.position = position;
    def.material.restitution = restitution;
    return def;
}

TEST(MoverBlow, GivesABallItsSpeedAndWhatBounces) {
    for (const float restitution : {0.0F, 0.3F, 0.8F, 1.0F}) {
        JointScene s;
        s.add(wall(Vec3(kWall_mps, 0, 0)));
        const BodyId ball = s.add(body_of(Shape::sphere(0.25F), Vec3(1, 0, 0), restitution));
        s.run(1.0F);
        EXPECT_NEAR(s.scene.state(ball).velocity.x(), (1.0F + restitution) * kWall_mps, 1.0e-3F);
    }
}

TEST(MoverBlow, GivesABallTheSpeedOfABatWhereItStrikes) {
    // A bat that turns about y strikes the ball with its face, 0.8 m from its axis: the ball leaves
    // along the face's normal, across the arm, with 2 w r.
    constexpr float kSpin_radps = 5.0F;
    constexpr float kArm_m = 0.8F;
    JointScene s;
    BodyDef bat;
    bat.kind = BodyKind::kKinematic;
    bat.shape = Shape::box(Vec3(1.0F, 0.5F, 0.02F));
    bat.position = Vec3::Zero();
    bat.angular_velocity = Vec3(0, -kSpin_radps, 0);  // what is at +x goes to +z
    s.add(bat);
    BodyDef def = body_of(Shape::sphere(0.05F), Vec3(kArm_m, 0, 0.3F), 1.0F);
    def.material.friction = 0.0F;
    const BodyId ball = s.add(def);
    s.run(0.5F);
    const float arm = std::hypot(kArm_m, 0.3F);
    // The point that touches lies up to radius and thickness nearer or farther than the centre.
    EXPECT_NEAR(s.scene.state(ball).velocity.norm(), 2.0F * kSpin_radps * arm, 0.7F);
}

TEST(MoverBlow, ReachesWhatHangsTogether) {
    JointScene s;
    s.add(wall(Vec3(kWall_mps, 0, 0)));
    const BodyId near = s.add(body_of(Shape::sphere(0.25F), Vec3(1, 0, 0), 1.0F));
    const BodyId far = s.add(body_of(Shape::sphere(0.25F), Vec3(2, 0, 0), 1.0F));
    JointDef bar;
    bar.kind = JointKind::kFixed;
    bar.a = near;
    bar.b = far;
    bar.anchor = Vec3(1.5F, 0, 0);
    s.join(bar);
    s.run(1.0F);
    for (const BodyId id : {near, far}) {
        EXPECT_NEAR(s.scene.state(id).velocity.x(), 2.0F * kWall_mps, 1.0e-3F);
    }
}

TEST(MoverBlow, GoesThroughAJoint) {
    // A ram that is fixed to a wall which goes on: as heavy as the wall.
    JointScene s;
    const BodyId carrier = s.add(wall(Vec3(kWall_mps, 0, 0)));
    BodyDef head = body_of(Shape::sphere(0.25F), Vec3(1, 0, 0), 1.0F);
    head.velocity = Vec3(kWall_mps, 0, 0);
    const BodyId ram = s.add(head);
    JointDef bar;
    bar.kind = JointKind::kFixed;
    bar.a = carrier;
    bar.b = ram;
    bar.anchor = Vec3(0.5F, 0, 0);
    s.join(bar);
    const BodyId ball = s.add(body_of(Shape::sphere(0.25F), Vec3(3, 0, 0), 1.0F));
    s.run(1.0F);
    EXPECT_NEAR(s.scene.state(ball).velocity.x(), 2.0F * kWall_mps, 1.0e-3F);
    EXPECT_NEAR(s.scene.state(ram).velocity.x(), kWall_mps, 1.0e-3F);
}

/// The state after 0.6 s of a spinning box that comes at a wall, in a frame in which the wall
/// has velocity `frame`.
BodyState after_a_blow(std::uint64_t seed, const Vec3& frame) {
    core::Rng rng(seed);
    JointScene s;
    s.add(wall(frame));
    const Vec3 half(rng.range(0.1F, 0.4F), rng.range(0.1F, 0.4F), rng.range(0.1F, 0.4F));
    BodyDef box = body_of(Shape::box(half), Vec3(1.2F, 0, 0), rng.range(0.2F, 1.0F));
    box.velocity = Vec3(rng.range(-8.0F, -2.0F), rng.range(-2.0F, 2.0F), 0.0F) + frame;
    box.angular_velocity = Vec3(0.0F, 0.0F, rng.range(-2.0F, 2.0F));
    const BodyId id = s.add(box);
    s.run(0.6F);
    return s.scene.state(id);
}

TEST(MoverBlow, IsTheSameInEveryFrame) {
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        core::Rng rng(1000 + seed);
        // Whole 64ths of a metre a step: the wall's positions are not rounded.
        const Vec3 frame(std::round(rng.range(-8.0F, 8.0F)) * 60.0F / 64.0F, 0.0F, 0.0F);
        const BodyState still = after_a_blow(seed, Vec3::Zero());
        const BodyState moving = after_a_blow(seed, frame);
        // A hundred roundings of 20 m/s, and of that over the box's least lever of 0.1 m.
        EXPECT_LT((moving.velocity - frame - still.velocity).norm(), 1e-4F) << seed;
        EXPECT_LT((moving.angular_velocity - still.angular_velocity).norm(), 1e-3F) << seed;
    }
}

}  // namespace
}  // namespace zoned::physics
