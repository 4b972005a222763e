// Forces, torques, impulses and damping against closed forms.
#include "server/physics/scene/scene.h"
#include "tests/unit/physics/physics_test.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics {
namespace {

Scene weightless_scene() {
    return Scene(weightless());
}

BodyId cube(Scene& scene, const Damping& damping = {}) {
    BodyDef def;
    def.shape = Shape::box(Vec3::Constant(0.5F));
    def.mass = 2.0F;
    def.damping = damping;
    return *scene.add(def);
}

TEST(Force, AtTheCentreAcceleratesAsNewtonSaysAndIsGoneAfterTheStep) {
    Scene scene = weightless_scene();
    const BodyId id = cube(scene);
    for (int i = 0; i < 60; ++i) {
        scene.apply_force(id, Vec3(3.0F, 0, 0));
        scene.apply_force(id, Vec3(1.0F, 0, 0));
        scene.step(kFrame);
    }
    // a = F / m = 2 m/s2 for one second. Constant acceleration is integrated exactly, so only 60
    // roundings of values up to 2 remain.
    EXPECT_NEAR(scene.state(id).velocity.x(), 2.0F, 60 * 2.0e-7F);
    EXPECT_NEAR(scene.state(id).position.x(), 1.0F, 60 * 2.0e-7F);
    scene.step(kFrame);
    EXPECT_NEAR(scene.state(id).velocity.x(), 2.0F, 60 * 2.0e-7F);
}

TEST(Force, OffTheCentreTurnsTheBodyToo) {
    Scene scene = weightless_scene();
    const BodyId id = cube(scene);
    scene.apply_force(id, Vec3(0, 12.0F, 0), Vec3(0.5F, 0, 0));
    scene.step(kFrame);
    // I = m s^2 / 6 = 1/3 kg m2; torque 6 N m about z for one step: w = 18 dt = 0.3 rad/s.
    EXPECT_NEAR(scene.state(id).angular_velocity.z(), 18.0F * kFrame, 1.0e-6F);
    EXPECT_NEAR(scene.state(id).velocity.y(), 6.0F * kFrame, 1.0e-6F);
}

TEST(Force, ThatIsNotFiniteStopsTheBodyAndIsCounted) {
    Scene scene = weightless_scene();
    const BodyId id = cube(scene);
    scene.apply_force(id, Vec3(NAN, 0, 0));
    EXPECT_EQ(scene.step(kFrame).quarantined, 1U);
    EXPECT_TRUE(scene.state(id).position.allFinite());
}

TEST(Impulse, AndItsOppositeBesideItTurnAndDoNotMove) {
    Scene scene = weightless_scene();
    const BodyId id = cube(scene);
    scene.apply_impulse(id, Vec3(0.5F, 0, 0), Vec3(0, 0, 0.5F));
    scene.apply_impulse(id, Vec3(-0.5F, 0, 0), Vec3(0, 0, -0.5F));
    EXPECT_NEAR(scene.state(id).angular_velocity.y(), 1.5F, 1.0e-6F);
    EXPECT_EQ(scene.state(id).velocity, Vec3(Vec3::Zero()));
}

TEST(Damping, SlowsDownAsTheExponentialSays) {
    Scene scene = weightless_scene();
    const BodyId id = cube(scene, {2.0F, 1.0F});
    BodyState state;
    state.velocity = Vec3(10, 0, 0);
    state.angular_velocity = Vec3(0, 0, 4);
    scene.set_state(id, state);
    for (int i = 0; i < 60; ++i) {
        scene.step(kFrame);
    }
    // Implicit steps of h give (1 + c h)^-n = e^-ct (1 + c^2 t h / 2 + ...): 3.3 % and 0.8 % more
    // than the exponential after one second.
    EXPECT_NEAR(scene.state(id).velocity.x(), 10.0F * std::exp(-2.0F), 0.035F * 1.36F);
    EXPECT_NEAR(scene.state(id).angular_velocity.z(), 4.0F * std::exp(-1.0F), 0.009F * 1.48F);
}

TEST(Damping, BringsAFallingBodyToItsFinalSpeed) {
    PhysicsSettings s;
    s.sleep_after_s = 0.0F;
    Scene scene(s);
    const BodyId id = cube(scene, {1.0F, 0.0F});
    for (int i = 0; i < 1200; ++i) {
        scene.step(kFrame);
    }
    // g / c; after 20 time constants e^-20 of it remains.
    EXPECT_NEAR(scene.state(id).velocity.y(), -9.81F, 1.0e-4F);
}

}  // namespace
}  // namespace zoned::physics
