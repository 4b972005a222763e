// Joints with all methods: motors, limits and springs have their stated effect.
#include "tests/unit/solver_variants/variant_scene.h"

#include <cmath>
#include <numbers>

namespace zoned::physics {
namespace {

struct Held {
    VariantScene s;
    BodyId body;
    JointId joint;

    Held(const PhysicsSettings& settings, JointDef def) : s(settings) {
        BodyDef box;
        box.shape = Shape::box(Vec3(0.5F, 0.2F, 0.3F));
        box.mass = 2.0F;
        body = s.add(box);
        def.b = body;
        const auto id = s.scene.add_joint(def);
        EXPECT_TRUE(id.ok());
        joint = *id;
    }
};

// A motor with torque to spare reaches its speed within the second: m r^2 w / 100 N m is 10 ms.
// Projection and penalties take steps towards it that leave e^-60 and the like of it per second.
TEST(SolverVariants, TurnAHingeAtTheSpeedOfItsMotor) {
    for (const SolverVariant method : all_methods()) {
        SCOPED_TRACE(name_of(method));
        JointDef def;
        def.kind = JointKind::kHinge;
        def.axis = Vec3::UnitY();
        def.motor = true;
        def.motor_speed = 2.0F;
        def.motor_max = 100.0F;
        Held held(settings_of(method, 30), def);
        held.s.run(1.0F);
        const BodyState state = held.s.scene.state(held.body);
        EXPECT_NEAR(state.angular_velocity.y(), 2.0F, 0.02F);
        EXPECT_LT(state.position.norm(), 0.02F);
    }
}

// The limit carries the body's weight. Penalties give by m g / k: w = 0.5 x 1.41 x 960 / s and nine
// rows on the body leave less than 9 g / w^2 = 0.2 mm.
TEST(SolverVariants, HoldASliderAtItsLimit) {
    for (const SolverVariant method : all_methods()) {
        SCOPED_TRACE(name_of(method));
        JointDef def;
        def.kind = JointKind::kSlider;
        def.axis = Vec3::UnitY();
        def.limited = true;
        def.lower = -0.5F;
        def.upper = 0.5F;
        Held held(settings_of(method, 60), def);
        held.s.run(3.0F);
        EXPECT_NEAR(held.s.scene.joint_position(held.joint), -0.5F, 0.01F);
        EXPECT_LT(held.s.scene.state(held.body).velocity.norm(), 0.05F);
    }
}

// At rest a spring of f hertz hangs down by g / (2 pi f)^2: 62 mm at 2 Hz, to 3 % of it.
TEST(SolverVariants, LetASpringHangByTheWeightOverItsStiffness) {
    for (const SolverVariant method : all_methods()) {
        SCOPED_TRACE(name_of(method));
        JointDef def;
        def.kind = JointKind::kSpring;
        def.anchor = Vec3(0.0F, 1.0F, 0.0F);
        def.anchor_b = Vec3::Zero();
        def.spring_hz = 2.0F;
        def.spring_damping_ratio = 1.0F;
        Held held(settings_of(method, 60), def);
        held.s.run(5.0F);
        const float w = 2.0F * std::numbers::pi_v<float> * 2.0F;
        EXPECT_NEAR(held.s.scene.state(held.body).position.y(), -kGravity / (w * w), 0.002F);
    }
}

}  // namespace
}  // namespace zoned::physics
