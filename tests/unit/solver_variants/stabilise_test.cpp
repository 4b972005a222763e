// Baumgarte's region of stability, the other methods to undo errors, and the energy meter.
#include "tests/unit/solver_variants/variant_scene.h"

#include <cmath>

namespace zoned::physics {
namespace {

struct Course {
    std::vector<float> errors;  ///< after each step, m
    double kinetic = 0.0;       ///< J, at the end
    double metered = 0.0;       ///< J, in less out
};

/// A distance joint of one row that is 1 mm too long, without gravity.
Course undo(PhysicsSettings settings, int steps) {
    settings.gravity.setZero();
    settings.methods.measure = true;
    VariantScene s(settings);
    JointDef joint;
    joint.kind = JointKind::kDistance;
    joint.b = s.sphere(Vec3(1.001F, 0.0F, 0.0F), Vec3::Zero(), 0.0F, 2.0F);
    joint.anchor_b = Vec3(1.001F, 0.0F, 0.0F);
    joint.length_m = 1.0F;
    EXPECT_TRUE(s.scene.add_joint(joint).ok());
    Course course;
    for (int i = 0; i < steps; ++i) {
        const VariantStats stats = s.scene.step(kFrame).method;
        course.metered += stats.bias_in_j - stats.bias_out_j;
        course.errors.push_back(s.scene.state(s.bodies[0]).position.x() - 1.0F);
    }
    course.kinetic = static_cast<double>(s.scene.state(s.bodies[0]).velocity.squaredNorm());
    return course;
}

PhysicsSettings with_beta(float beta) {
    PhysicsSettings settings = settings_of(SolverVariant::kGaussSeidel);
    settings.methods.beta = beta;
    return settings;
}

// One row: each step multiplies the error by 1 - beta. Positions about 1 m round to 6e-8.
TEST(Baumgarte, MultipliesTheErrorOfASingleRowByOneMinusBeta) {
    for (const float beta : {0.1F, 0.5F, 1.0F, 1.5F}) {
        const Course course = undo(with_beta(beta), 5);
        float expected = 0.001F;
        for (const float error : course.errors) {
            expected *= 1.0F - beta;
            EXPECT_NEAR(error, expected, 5.0e-7F) << beta;
        }
    }
}

TEST(Baumgarte, IsStableForBetaBelowTwoAndGainsEnergyWithoutEndBeyond) {
    for (const float beta : {0.05F, 0.5F, 1.0F, 1.5F, 1.9F}) {
        const Course course = undo(with_beta(beta), 200);
        EXPECT_LT(std::abs(course.errors.back()), 1.0e-4F) << beta;
        EXPECT_LT(course.kinetic, 1.0e-5) << beta;
    }
    const Course beyond = undo(with_beta(2.1F), 60);
    EXPECT_GT(std::abs(beyond.errors.back()), 0.1F);
    EXPECT_GT(beyond.kinetic, 10.0);
}

// The only row undoes errors: its energy in less its energy out is the body's energy. Mass 2: the
// kinetic energy is v^2.
TEST(EnergyMeter, AccountsForAllOfTheKineticEnergy) {
    for (const auto mode :
         {Stabilisation::kBaumgarte, Stabilisation::kSoft, Stabilisation::kSplit}) {
        for (const int steps : {1, 3, 20}) {
            PhysicsSettings settings = with_beta(0.3F);
            settings.methods.stabilisation = mode;
            settings.methods.soft_damping_ratio = 0.2F;
            const Course course = undo(settings, steps);
            EXPECT_NEAR(course.metered, course.kinetic, 1.0e-6 * (1.0e-3 + course.kinetic));
        }
    }
}

// Positions go by the same factor, and velocities do not change.
TEST(SplitImpulses, UndoAnErrorWithoutAnyVelocity) {
    PhysicsSettings settings = with_beta(0.3F);
    settings.methods.stabilisation = Stabilisation::kSplit;
    const Course course = undo(settings, 10);
    EXPECT_NEAR(course.errors.back(), 0.001F * std::pow(0.7F, 10.0F), 1.0e-6F);
    EXPECT_EQ(course.kinetic, 0.0);
    EXPECT_EQ(course.metered, 0.0);
}

// Implicit Euler of a spring and damper of 5 Hz: x'' = -w^2 x - 2 zeta w x'.
TEST(SoftRows, MoveAsASpringAndDamperDoByImplicitEuler) {
    PhysicsSettings settings = with_beta(0.0F);
    settings.methods.stabilisation = Stabilisation::kSoft;
    settings.methods.soft_hz = 5.0F;
    settings.methods.soft_damping_ratio = 0.7F;
    const Course course = undo(settings, 20);
    const double w = 2.0 * 3.14159265358979 * 5.0;
    const double h = 1.0 / 60.0;
    double x = 0.001;
    double v = 0.0;
    for (const float error : course.errors) {
        v = (v - h * w * w * x) / (1.0 + 2.0 * 0.7 * w * h + h * h * w * w);
        x += h * v;
        EXPECT_NEAR(error, x, 1.0e-6);
    }
}

// Two boxes that start 5 cm within each other and the ground: all methods part them. Those with a
// bias on velocities throw the upper one up, split impulses do not.
TEST(Stabilisation, PartsOverlapsAndOnlySplitImpulsesDoSoWithoutThrowing) {
    const auto highest = [](Stabilisation mode, float beta) {
        PhysicsSettings settings = settings_of(SolverVariant::kGaussSeidel, 60);
        settings.methods.stabilisation = mode;
        settings.methods.beta = beta;
        VariantScene s(settings);
        s.ground();
        s.box(Vec3(0.0F, 0.45F, 0.0F));
        s.box(Vec3(0.0F, 1.40F, 0.0F));
        float top = 0.0F;
        for (int i = 0; i < 120; ++i) {
            s.scene.step(kFrame);
            top = std::max(top, s.scene.state(s.bodies[1]).position.y());
        }
        EXPECT_NEAR(s.scene.state(s.bodies[1]).position.y(), 1.5F, 0.02F);
        return top;
    };
    EXPECT_LT(highest(Stabilisation::kSplit, 0.4F), 1.505F);
    EXPECT_GT(highest(Stabilisation::kBaumgarte, 0.8F), 1.55F);
    EXPECT_LT(highest(Stabilisation::kSoft, 0.0F), 1.505F);
}

}  // namespace
}  // namespace zoned::physics
