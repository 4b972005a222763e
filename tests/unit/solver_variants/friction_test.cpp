// Models of friction and of manifolds: common and different results.
#include "tests/unit/solver_variants/problems.h"

#include <numbers>

namespace zoned::physics {
namespace {

constexpr float kFriction = 0.3F;

/// Mean deceleration over half a second of a box that slides at 4 m/s at `angle` from the x axis,
/// with `load` times its weight on it, in units of friction x g.
float deceleration(SolverVariant method,
                   FrictionModel model,
                   ManifoldMode manifold,
                   float angle,
                   float load = 1.0F) {
    PhysicsSettings settings = settings_of(method, 200);
    settings.methods.friction = model;
    settings.methods.manifold = manifold;
    VariantScene s(settings);
    s.ground(kFriction);
    const BodyId box = s.box(Vec3(0.0F, 0.5F, 0.0F), 1.0F, kFriction);
    const Vec3 along(std::cos(angle), 0.0F, std::sin(angle));
    s.run(0.2F);
    s.scene.set_velocity(box, 4.0F * along, Vec3::Zero());
    for (int i = 0; i < 30; ++i) {
        s.scene.apply_force(box, Vec3(0.0F, (1.0F - load) * kGravity, 0.0F));
        s.scene.step(kFrame);
    }
    const Vec3 v = s.scene.state(box).velocity;
    return (4.0F - v.dot(along)) / (0.5F * kFriction * kGravity);
}

constexpr float kDiagonal = 0.25F * std::numbers::pi_v<float>;

// Velocities change by friction x g h in each step exactly; 2 % covers that the box leans back by
// its overlap when it starts.
TEST(Friction, OfAConeIsTheSameInAllDirections) {
    for (const ManifoldMode manifold : {ManifoldMode::kPoints, ManifoldMode::kDivided}) {
        for (const float angle : {0.0F, 0.3F, kDiagonal, 1.2F}) {
            EXPECT_NEAR(
                deceleration(SolverVariant::kGaussSeidel, FrictionModel::kCone, manifold, angle),
                1.0F,
                0.02F);
        }
    }
}

// Tangents lie along x and z: between them both limits add up to sqrt(2) of either.
TEST(Friction, OfAPyramidIsUpToSqrtTwoStrongerBetweenItsTangents) {
    for (const ManifoldMode manifold : {ManifoldMode::kPoints, ManifoldMode::kDivided}) {
        EXPECT_NEAR(
            deceleration(SolverVariant::kGaussSeidel, FrictionModel::kPyramid, manifold, 0.0F),
            1.0F,
            0.02F);
        EXPECT_NEAR(
            deceleration(SolverVariant::kGaussSeidel, FrictionModel::kPyramid, manifold, kDiagonal),
            std::numbers::sqrt2_v<float>,
            0.03F);
    }
}

TEST(Friction, ByWeightDoesNotSeeTheLoad) {
    const auto measure = [](FrictionModel model) {
        return deceleration(SolverVariant::kGaussSeidel, model, ManifoldMode::kPoints, 0.0F, 2.0F);
    };
    EXPECT_NEAR(measure(FrictionModel::kCone), 2.0F, 0.04F);
    EXPECT_NEAR(measure(FrictionModel::kWeight), 1.0F, 0.02F);
}

TEST(Friction, SlowsASlidingBoxAsCoulombSaysWithEveryMethod) {
    for (const SolverVariant method : all_methods()) {
        SCOPED_TRACE(name_of(method));
        EXPECT_NEAR(
            deceleration(method, FrictionModel::kCone, ManifoldMode::kPoints, 0.4F), 1.0F, 0.05F);
    }
}

/// The force of friction that the exact solver gives a box that slips at `angle`, N s per N s of
/// load.
double friction_share(FrictionModel model, float angle) {
    VariantScene s(problem_settings(model, ManifoldMode::kPoints));
    s.ground(kFriction);
    const BodyId box = s.box(Vec3(0.0F, 0.5F, 0.0F), 1.0F, kFriction);
    s.scene.set_velocity(box, Vec3(std::cos(angle), 0.0F, std::sin(angle)), Vec3::Zero());
    RowSystem rows = problem_of(s);
    EXPECT_EQ(solve_direct(rows, IterationLimits()).direct, 1U);
    double load = 0.0;
    Vec3d rub = Vec3d::Zero();
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (rows.rub[i] != 0) {
            rub += rows.lambda[i] * rows.shape[i].linear;
        } else {
            load += rows.lambda[i];
        }
    }
    return rub.norm() / load;
}

TEST(Friction, OfTheExactSolverLiesOnTheConeAndAtThePyramidsCorner) {
    const auto mu = static_cast<double>(kFriction);
    EXPECT_NEAR(friction_share(FrictionModel::kCone, 0.7F), mu, 1.0e-6);
    EXPECT_NEAR(friction_share(FrictionModel::kPyramid, 0.7F), std::numbers::sqrt2 * mu, 1.0e-6);
}

/// Sum of the impulses on the ground over a second, N s.
float load_of(ManifoldMode manifold) {
    PhysicsSettings settings = settings_of(SolverVariant::kGaussSeidel, 50);
    settings.methods.manifold = manifold;
    settings.event_impulse_ns = 0.0F;
    VariantScene s(settings);
    s.ground();
    s.box(Vec3(0.0F, 0.5F, 0.0F), 2.0F);
    s.run(1.0F);
    float sum = 0.0F;
    for (int i = 0; i < 60; ++i) {
        s.scene.step(kFrame);
        for (const ContactEvent& event : s.scene.contact_events()) {
            sum += event.impulse;
        }
    }
    return sum;
}

// At rest both must carry the weight: m g times a second, to the rounding of 60 sums.
TEST(Manifold, CarriesTheSameLoadPointByPointAndDivided) {
    EXPECT_NEAR(load_of(ManifoldMode::kPoints), 2.0F * kGravity, 0.01F);
    EXPECT_NEAR(load_of(ManifoldMode::kDivided), 2.0F * kGravity, 0.01F);
}

TEST(Manifold, DividedAsksForFourRowsInsteadOfTwelve) {
    EXPECT_EQ(boxes_on_ground(FrictionModel::kCone, ManifoldMode::kPoints).size(), 36U);
    EXPECT_EQ(boxes_on_ground(FrictionModel::kCone, ManifoldMode::kDivided).size(), 12U);
}

}  // namespace
}  // namespace zoned::physics
