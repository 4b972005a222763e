// Penalty forces on both sides of the longest stable time step.
#include "server/physics/solver_variants/collision_response.h"
#include "tests/unit/solver_variants/variant_scene.h"

#include <cmath>

namespace zoned::physics {
namespace {

/// The largest error of a distance joint of 1 m in the second half of 600 steps, from 1 cm. A joint
/// of one row on one body is a single spring of exactly the frequency that the share says.
float swing(float share, float damping, PenaltyIntegrator integrator) {
    PhysicsSettings settings = settings_of(SolverVariant::kPenalty);
    settings.gravity.setZero();
    settings.substeps = 1;
    settings.methods.penalty_share = share;
    settings.methods.penalty_damping_ratio = damping;
    settings.methods.penalty_integrator = integrator;
    VariantScene s(settings);
    JointDef joint;
    joint.kind = JointKind::kDistance;
    joint.b = s.sphere(Vec3(1.01F, 0.0F, 0.0F), Vec3::Zero(), 0.0F);
    joint.anchor_b = Vec3(1.01F, 0.0F, 0.0F);
    joint.length_m = 1.0F;
    EXPECT_TRUE(s.scene.add_joint(joint).ok());
    float largest = 0.0F;
    for (int i = 0; i < 600; ++i) {
        s.scene.step(kFrame);
        const float x = s.scene.state(s.bodies[0]).position.x();
        if (i >= 300 || !(std::abs(x - 1.0F) < 1.0F)) {
            largest = std::max(largest, std::abs(x - 1.0F));
        }
    }
    return largest;
}

// Semi-implicit Euler, below the limit: the swing of an undamped spring keeps its size (up to 1 /
// sqrt(1 - share^2) = 5 at 0.98, the ellipse of the map), and a damped one dies out. Above the
// limit it grows by a factor per step, 1.2 at 1.02 without damping: 1e47 in 600.
TEST(PenaltyMethod, IsStableUpToTheLimitAndNotBeyond) {
    const auto euler = PenaltyIntegrator::kSemiImplicitEuler;
    EXPECT_LT(swing(0.98F, 0.0F, euler), 0.06F);
    EXPECT_GT(swing(1.02F, 0.0F, euler), 0.5F);
    EXPECT_LT(swing(0.98F, 0.3F, euler), 0.005F);
    EXPECT_GT(swing(1.02F, 0.3F, euler), 0.5F);
    EXPECT_LT(swing(0.98F, 1.0F, euler), 0.005F);
    EXPECT_GT(swing(1.02F, 1.0F, euler), 0.5F);
}

// Velocity Verlet has the same limit without damping, 2 / w. At it the velocity's part of the
// ellipse shrinks where Euler's grows: the swing itself is never larger than it was.
TEST(PenaltyMethod, HasTheSameLimitWithVelocityVerlet) {
    const auto verlet = PenaltyIntegrator::kVelocityVerlet;
    EXPECT_LT(swing(0.98F, 0.0F, verlet), 0.0101F);
    EXPECT_GT(swing(1.02F, 0.0F, verlet), 0.5F);
    EXPECT_LT(swing(0.98F, 0.3F, verlet), 0.005F);
}

TEST(PenaltyMethod, KnowsItsLimit) {
    EXPECT_DOUBLE_EQ(penalty_limit(0.0), 2.0);
    for (const double zeta : {0.1, 0.5, 1.0, 2.0}) {
        // The root z = -1 of z^2 - (2 - 2 zeta x - x^2) z + (1 - 2 zeta x) at x = w h.
        const double x = penalty_limit(zeta);
        EXPECT_NEAR(1.0 + (2.0 - 2.0 * zeta * x - x * x) + (1.0 - 2.0 * zeta * x), 0.0, 1.0e-12);
        EXPECT_LT(zeta * x, 1.0) << "the other root is within the circle too";
    }
}

// A body's rows share its mass, so that no mode of all springs is faster than that of one. A stack
// with contacts all over therefore stays calm at a share just below 1. A box on four points of
// twelve rows sinks by m g / sum k = g x 12 x (1 + 3.75) / (4 w^2), with 3.75 = r^2 m / I at a
// corner. That is less than 14.3 g / w^2: 0.5 mm at 16 substeps.
TEST(PenaltyMethod, KeepsAStackStableJustBelowTheLimit) {
    for (const auto integrator :
         {PenaltyIntegrator::kSemiImplicitEuler, PenaltyIntegrator::kVelocityVerlet}) {
        PhysicsSettings settings = settings_of(SolverVariant::kPenalty);
        settings.methods.penalty_share = 0.95F;
        settings.methods.penalty_integrator = integrator;
        VariantScene s(settings);
        s.ground();
        for (int i = 0; i < 4; ++i) {
            s.box(Vec3(0.0F, 0.5F + static_cast<float>(i), 0.0F));
        }
        s.run(4.0F);
        for (std::size_t i = 0; i < 4; ++i) {
            const BodyState state = s.scene.state(s.bodies[i]);
            EXPECT_NEAR(state.position.y(), 0.5F + static_cast<float>(i), 0.02F);
            EXPECT_LT(state.velocity.norm(), 0.05F);
        }
    }
}

}  // namespace
}  // namespace zoned::physics
