// Bodies at rest and under friction: stacks, inclines, rolling.
#include "server/physics/scene/scene.h"
#include "tests/unit/physics/hulls.h"
#include "tests/unit/physics/joint_scene.h"
#include "tests/unit/physics/physics_test.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics {
namespace {

BodyId ground(Scene& scene, float friction, const Quat& tilt = Quat::Identity()) {
    BodyDef def;
    def.kind = BodyKind::kStatic;
    def.shape = Shape::box(Vec3(100, 0.5F, 100));
    def.orientation = tilt;
    def.position = tilt * Vec3(0, -0.5F, 0);
    def.material.friction = friction;
    return *scene.add(def);
}

void stack_stands(bool sleeping, const Shape& shape = Shape::box(Vec3::Constant(0.5F))) {
    PhysicsSettings s;
    s.sleep_after_s = sleeping ? 0.5F : 0.0F;
    Scene scene(s);
    ground(scene, 0.5F);
    std::vector<BodyId> boxes;
    for (int i = 0; i < 5; ++i) {
        BodyDef def;
        def.shape = shape;
        def.position = Vec3(0, 0.5F + static_cast<float>(i), 0);
        boxes.push_back(*scene.add(def));
    }
    for (int i = 0; i < 300; ++i) {
        scene.step(kTick);
    }
    for (int i = 0; i < 5; ++i) {
        const BodyState state = scene.state(boxes[static_cast<std::size_t>(i)]);
        EXPECT_LT((state.position - Vec3(0, 0.5F + static_cast<float>(i), 0)).norm(), 0.01F) << i;
    }
    EXPECT_EQ(scene.awake_count(), sleeping ? 0U : 5U);
}

TEST(Stack, OfFiveStandsForTenSecondsAwake) {
    stack_stands(false);
}

TEST(Stack, OfFiveStandsForTenSecondsAndSleeps) {
    stack_stands(true);
}

TEST(Stack, OfFiveHullsThatAreBoxesStandsAsBoxesDo) {
    const Shape cube = hull_shape(box_corners(Vec3::Constant(0.5F)));
    stack_stands(false, cube);
    stack_stands(true, cube);
}

/// Distance slid along a 30 degree incline.
float slide(float friction, float seconds) {
    PhysicsSettings s;
    s.sleep_after_s = 0.0F;
    Scene scene(s);
    const Quat tilt(Eigen::AngleAxisf(30.0F / 180.0F * 3.14159265F, Vec3::UnitZ()));
    ground(scene, friction, tilt);
    BodyDef def;
    def.shape = Shape::box(Vec3::Constant(0.5F));
    def.material.friction = friction;
    def.orientation = tilt;
    def.position = tilt * Vec3(0, 0.5F, 0);
    const BodyId id = *scene.add(def);
    for (int i = 0; i < static_cast<int>(std::lround(seconds / kTick)); ++i) {
        scene.step(kTick);
    }
    return -(tilt.conjugate() * (scene.state(id).position - def.position)).x();
}

TEST(Incline, LetsABoxSlideAsCoulombSays) {
    // (g sin a - mu g cos a) t^2 / 2 for mu = 0.5, a = 30 degrees, t = 3 s. The integrator is exact
    // for it. The remaining error is the first step's settling onto the spring of the contact, of
    // the order of one substep's travel v h = 1.3 m/s / 120.
    const float exact = (9.81F * 0.5F - 0.5F * 9.81F * 0.8660254F) * 9.0F / 2.0F;
    EXPECT_NEAR(slide(0.5F, 3.0F), exact, 0.01F);
}

TEST(Incline, HoldsABoxBelowTheAngleOfFriction) {
    // tan 30 degrees = 0.577 < 0.6. Creep for ten seconds stays under a tenth of a millimetre.
    EXPECT_LT(std::abs(slide(0.6F, 10.0F)), 1e-3F);
}

TEST(Incline, RollsASphereAtFiveSeventhsOfTheSlope) {
    PhysicsSettings s;
    s.sleep_after_s = 0.0F;
    Scene scene(s);
    const Quat tilt(Eigen::AngleAxisf(0.2F, Vec3::UnitZ()));
    ground(scene, 0.9F, tilt);
    BodyDef def;
    def.shape = Shape::sphere(0.5F);
    def.material.friction = 0.9F;
    def.position = tilt * Vec3(0, 0.5F, 0);
    const BodyId id = *scene.add(def);
    for (int i = 0; i < 60; ++i) {
        scene.step(kTick);
    }
    // a = g sin(alpha) / (1 + I / (m r^2)) with I = 2/5 m r^2.
    const float a = 9.81F * std::sin(0.2F) / 1.4F;
    const float distance = -(tilt.conjugate() * (scene.state(id).position - def.position)).x();
    EXPECT_NEAR(distance, a * 4.0F / 2.0F, 0.005F * a * 2.0F);
    const Vec3 spin = tilt.conjugate() * scene.state(id).angular_velocity;
    EXPECT_NEAR(spin.z(), a * 2.0F / 0.5F, 0.01F * a * 4.0F);  // rolls: v = w r
}

TEST(Box, StandsOnItsEdgeContactAcrossAnother) {
    // Two boxes with crossed edges: only the edge-edge axis gives the contact.
    PhysicsSettings s;
    s.sleep_after_s = 0.0F;
    Scene scene(s);
    BodyDef lower;
    lower.kind = BodyKind::kStatic;
    lower.shape = Shape::box(Vec3(2.0F, 0.5F, 0.5F));
    lower.orientation = Quat(Eigen::AngleAxisf(3.14159265F / 4, Vec3::UnitX()));
    lower.material.friction = 1.0F;
    ASSERT_TRUE(scene.add(lower).ok());
    const float edge = 0.5F * std::sqrt(2.0F);
    BodyDef upper;
    upper.shape = Shape::box(Vec3(0.5F, 0.5F, 2.0F));
    upper.orientation = Quat(Eigen::AngleAxisf(3.14159265F / 4, Vec3::UnitZ()));
    upper.position = Vec3(0, 2.0F * edge, 0);
    upper.material.friction = 1.0F;
    const BodyId id = *scene.add(upper);
    for (int i = 0; i < 10; ++i) {
        scene.step(kTick);
    }
    // A balance on a point topples in time, but not within a third of a second from rest.
    EXPECT_NEAR(scene.state(id).position.y(), 2.0F * edge, 0.01F);
}

TEST(ThrownBox, DoesNotPassAWall) {
    for (const float speed : {20.0F, 60.0F, 200.0F}) {
        for (int start = 0; start < 20; ++start) {
            Scene scene{PhysicsSettings()};
            BodyDef wall;
            wall.kind = BodyKind::kStatic;
            wall.shape = Shape::box(Vec3(0.25F, 3.0F, 3.0F));
            ASSERT_TRUE(scene.add(wall).ok());
            BodyDef prop;
            prop.shape = Shape::box(Vec3::Constant(0.2F));
            prop.position = Vec3(-5.0F - 0.05F * speed * kTick * static_cast<float>(start), 1, 0);
            prop.velocity = Vec3(speed, 0, 0);
            prop.angular_velocity = Vec3(1, 2, 3);
            const BodyId id = *scene.add(prop);
            for (int i = 0; i < 30; ++i) {
                scene.step(kTick);
                ASSERT_LT(scene.state(id).position.x(), 0.0F) << speed << " " << start;
            }
        }
    }
}

float apex_after(float restitution, float dt, int bounces, float height) {
    PhysicsSettings s;
    s.sleep_after_s = 0.0F;
    Scene scene(s);
    BodyDef floor;
    floor.kind = BodyKind::kStatic;
    floor.shape = Shape::plane();
    floor.material = {0.0F, restitution};
    EXPECT_TRUE(scene.add(floor).ok());
    BodyDef ball;
    ball.shape = Shape::sphere(0.5F);
    ball.position = Vec3(0, 0.5F + height, 0);
    ball.material = {0.0F, restitution};
    const BodyId id = *scene.add(ball);
    float previous = 0.0F;
    for (int i = 0; i < 20000; ++i) {
        scene.step(dt);
        const BodyState state = scene.state(id);
        if (previous > 0.0F && state.velocity.y() <= 0.0F && --bounces == 0) {
            // Height of the apex from the energy, which does not depend on where the step falls.
            return state.position.y() - 0.5F + state.velocity.squaredNorm() / (2.0F * 9.81F);
        }
        previous = state.velocity.y();
    }
    return -1.0F;
}

TEST(Bounce, LosesEnergyAsRestitutionSaysWhateverTheTimeStep) {
    // Height goes with e^2 per bounce. The step adds an error: the speed of impact is taken from
    // the energy at the start of the substep. The ball leaves from where it was stopped, which is
    // within the contact spring's sag.
    for (const float dt : {1.0F / 30.0F, 1.0F / 60.0F, 1.0F / 240.0F}) {
        EXPECT_NEAR(apex_after(1.0F, dt, 1, 10.0F), 10.0F, 0.01F) << dt;
        EXPECT_NEAR(apex_after(1.0F, dt, 10, 10.0F), 10.0F, 0.05F) << dt;
        EXPECT_NEAR(apex_after(0.8F, dt, 1, 10.0F), 6.4F, 0.01F) << dt;
        EXPECT_NEAR(apex_after(0.8F, dt, 3, 10.0F), 10.0F * std::pow(0.64F, 3.0F), 0.02F) << dt;
    }
}

/// A ball that swings on a spring without damping, at three times the sleep speed and more: it is
/// never slow for half a second.
struct SwingingBall : JointScene {
    BodyId ball;

    explicit SwingingBall(float amplitude) : JointScene(Vec3::Zero(), true) {
        ball = add(Shape::sphere(0.1F), 1.0F, Vec3(1.0F + amplitude, 0.0F, 0.0F));
        JointDef spring = joint_of(JointKind::kSpring, BodyId(), ball, Vec3::Zero());
        spring.anchor_b = Vec3(1.0F + amplitude, 0.0F, 0.0F);
        spring.length_m = 1.0F;
        spring.spring_hz = 6.0F;
        spring.spring_damping_ratio = 0.0F;
        join(spring);
    }
};

TEST(Settling, WhatStaysWithinACentimetreFallsAsleep) {
    SwingingBall swing(0.004F);
    swing.run(3.0F);
    EXPECT_EQ(swing.scene.awake_count(), 1U);
    swing.run(2.0F);
    EXPECT_EQ(swing.scene.awake_count(), 0U);
}

TEST(Settling, WhatSwingsFartherStaysAwake) {
    SwingingBall swing(0.02F);
    swing.run(20.0F);
    EXPECT_EQ(swing.scene.awake_count(), 1U);
}

TEST(Settling, WhatIsPushedStaysAwake) {
    SwingingBall swing(0.004F);
    for (int i = 0; i < 600; ++i) {
        swing.scene.apply_force(swing.ball, Vec3(0.0F, 1.0e-6F, 0.0F));
        swing.scene.step(kFrame);
    }
    EXPECT_EQ(swing.scene.awake_count(), 1U);
}

}  // namespace
}  // namespace zoned::physics
