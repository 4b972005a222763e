// The section physics: the method that solves contacts, and its parameters, as the config says.
#include "tests/unit/config/config_helpers.h"

namespace zoned::config::test {
namespace {

TEST(PhysicsMethod, IsTheEnginesOwnDefaultWithoutASection) {
    const Outcome out = parse(kValid);
    ASSERT_TRUE(out.ok);
    const physics::PhysicsSettings& got = out.settings.physics;
    const physics::PhysicsSettings engine;
    EXPECT_EQ(got.method, engine.method);
    const physics::VariantSettings& m = got.methods;
    const physics::VariantSettings& e = engine.methods;
    EXPECT_EQ(m.iterations, e.iterations);
    EXPECT_EQ(m.tolerance_mps, e.tolerance_mps);
    EXPECT_EQ(m.omega, e.omega);
    EXPECT_EQ(m.shuffle, e.shuffle);
    EXPECT_EQ(m.warm_start, e.warm_start);
    EXPECT_EQ(m.direct_rows, e.direct_rows);
    EXPECT_EQ(m.friction, e.friction);
    EXPECT_EQ(m.manifold, e.manifold);
    EXPECT_EQ(m.stabilisation, e.stabilisation);
    EXPECT_EQ(m.beta, e.beta);
    EXPECT_EQ(m.soft_hz, e.soft_hz);
    EXPECT_EQ(m.soft_damping_ratio, e.soft_damping_ratio);
    EXPECT_EQ(m.push_speed_mps, e.push_speed_mps);
    EXPECT_EQ(m.slop_m, e.slop_m);
    EXPECT_EQ(m.penalty_share, e.penalty_share);
    EXPECT_EQ(m.penalty_damping_ratio, e.penalty_damping_ratio);
    EXPECT_EQ(m.penalty_integrator, e.penalty_integrator);
}

TEST(PhysicsMethod, ReachesTheEngineWithAllOfItsParameters) {
    const Outcome out = parse(kValid + R"(physics {
  method: CONJUGATE_GRADIENT
  method_parameters {
    iterations: 7 tolerance_mps: 0.5 omega: 1.5 shuffle: 9 warm_start: false direct_rows: 33
    friction: PYRAMID manifold: DIVIDED stabilisation: SPLIT beta: 0.75 soft_hz: 4
    soft_damping_ratio: 2 push_speed_mps: 8 slop_m: 0.0625 penalty_share: 0.25
    penalty_damping_ratio: 0.5 penalty_integrator: VELOCITY_VERLET
  }
}
)");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(out.settings.physics.method, physics::SolverVariant::kConjugateGradient);
    const physics::VariantSettings& m = out.settings.physics.methods;
    EXPECT_EQ(m.iterations, 7);
    EXPECT_EQ(m.tolerance_mps, 0.5F);
    EXPECT_EQ(m.omega, 1.5F);
    EXPECT_EQ(m.shuffle, 9U);
    EXPECT_FALSE(m.warm_start);
    EXPECT_EQ(m.direct_rows, 33);
    EXPECT_EQ(m.friction, physics::FrictionModel::kPyramid);
    EXPECT_EQ(m.manifold, physics::ManifoldMode::kDivided);
    EXPECT_EQ(m.stabilisation, physics::Stabilisation::kSplit);
    EXPECT_EQ(m.beta, 0.75F);
    EXPECT_EQ(m.soft_hz, 4.0F);
    EXPECT_EQ(m.soft_damping_ratio, 2.0F);
    EXPECT_EQ(m.push_speed_mps, 8.0F);
    EXPECT_EQ(m.slop_m, 0.0625F);
    EXPECT_EQ(m.penalty_share, 0.25F);
    EXPECT_EQ(m.penalty_damping_ratio, 0.5F);
    EXPECT_EQ(m.penalty_integrator, physics::PenaltyIntegrator::kVelocityVerlet);
}

TEST(PhysicsMethod, RefusesAShareAtWhichSpringsAreUnstable) {
    expect_single(kValid + "physics { method_parameters { penalty_share: 1.5 } }\n",
                  "penalty_share: 1.5",
                  "0.95");
}

TEST(PhysicsMethod, RefusesANameThatItDoesNotKnow) {
    const Outcome out = parse(kValid + "physics { method: GAUSS }\n");
    EXPECT_FALSE(out.ok);
}

}  // namespace
}  // namespace zoned::config::test
