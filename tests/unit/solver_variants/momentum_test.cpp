// Impacts by closed forms, and momentum, which no method may change.
#include "tests/unit/solver_variants/variant_scene.h"

namespace zoned::physics {
namespace {

PhysicsSettings weightless(SolverVariant method) {
    PhysicsSettings settings = settings_of(method, 60);
    settings.gravity.setZero();
    return settings;
}

struct Momentum {
    Vec3d linear = Vec3d::Zero();
    Vec3d angular = Vec3d::Zero();
};

/// Boxes of these half extents and of mass 1 to 3.
Momentum momentum_of(const VariantScene& s, const Vec3d& half) {
    Momentum sum;
    double mass = 0.0;
    for (const BodyId body : s.bodies) {
        mass += 1.0;
        const BodyState state = s.scene.state(body);
        const Vec3d x = state.position.cast<double>();
        const Vec3d v = state.velocity.cast<double>();
        const Vec3d square = half.cwiseAbs2();
        const Vec3d inertia =
            (mass / 3.0) *
            Vec3d(square.y() + square.z(), square.z() + square.x(), square.x() + square.y());
        const Eigen::Matrix3d axes = state.orientation.toRotationMatrix().cast<double>();
        const Vec3d spin = state.angular_velocity.cast<double>();
        sum.linear += mass * v;
        sum.angular +=
            mass * x.cross(v) + axes * inertia.cwiseProduct(Vec3d(axes.transpose() * spin));
    }
    return sum;
}

// Three boxes meet askew, with friction and some bounce. Momentum is of the order of 10 kg m/s and
// kg m2/s: floats round it by 1e-6 in each of 90 steps. Angular momentum may change by an impulse
// of that size at two points that rounding of positions and a manifold that was kept for 0.2 mm
// part. Projection pushes at points that have slipped against each other since the substep began,
// by 4 m/s / 240: some 2 % of the moment of an impulse.
TEST(SolverVariants, ConserveMomentumInAnImpactAskew) {
    for (const SolverVariant method : all_methods()) {
        SCOPED_TRACE(name_of(method));
        VariantScene s(weightless(method));
        const Vec3 half(0.5F, 0.3F, 0.7F);
        for (int i = 0; i < 3; ++i) {
            BodyDef def;
            def.shape = Shape::box(half);
            def.mass = static_cast<float>(i + 1);
            def.material.friction = 0.6F;
            def.material.restitution = 0.4F;
            def.position = Vec3(2.0F * static_cast<float>(i), 0.15F * static_cast<float>(i), 0.0F);
            def.velocity = Vec3(i == 0 ? 4.0F : -1.0F, 0.0F, 0.2F * static_cast<float>(i));
            def.angular_velocity = Vec3(0.3F, 0.5F, -0.4F * static_cast<float>(i));
            s.add(def);
        }
        const Momentum before = momentum_of(s, half.cast<double>());
        s.run(1.5F);
        const Momentum after = momentum_of(s, half.cast<double>());
        EXPECT_GT((s.scene.state(s.bodies[0]).velocity - Vec3(4.0F, 0.0F, 0.0F)).norm(), 1.0F);
        EXPECT_LT((after.linear - before.linear).norm(), 1.0e-4);
        const double most = method == SolverVariant::kProjection ? 0.2 : 0.01;
        EXPECT_LT((after.angular - before.angular).norm(), most);
    }
}

/// SolverVariants that know restitution.
std::vector<SolverVariant> bouncing_methods() {
    std::vector<SolverVariant> methods = row_methods();
    methods.push_back(SolverVariant::kImpulse);
    methods.push_back(SolverVariant::kProjection);
    return methods;
}

// v1' = (m1 v1 + m2 v2 - m2 e (v1 - v2)) / (m1 + m2), v2' likewise. One row: a pass of Gauss-Seidel
// is exact, Jacobi's steps shrink the error by 1 - 1.5 of it: 60 of them reach rounding.
TEST(Restitution, MakesTwoSpheresPartAsTheClosedFormSays) {
    for (const SolverVariant method : bouncing_methods()) {
        for (const float e : {0.0F, 0.5F, 1.0F}) {
            SCOPED_TRACE(name_of(method) + ", e " + std::to_string(e));
            VariantScene s(weightless(method));
            s.sphere(Vec3(-1.0F, 0.0F, 0.0F), Vec3(2.0F, 0.0F, 0.0F), e, 1.0F);
            s.sphere(Vec3(1.0F, 0.0F, 0.0F), Vec3(-1.0F, 0.0F, 0.0F), e, 3.0F);
            s.run(1.0F);
            const float mean = (1.0F * 2.0F - 3.0F * 1.0F) / 4.0F;
            const float v1 = mean - 0.75F * e * 3.0F;
            const float v2 = mean + 0.25F * e * 3.0F;
            EXPECT_NEAR(s.scene.state(s.bodies[0]).velocity.x(), v1, 1.0e-5F);
            EXPECT_NEAR(s.scene.state(s.bodies[1]).velocity.x(), v2, 1.0e-5F);
        }
    }
}

// A sphere hits a free box at d from the middle of its face: j = (1 + e) v / (1/M + 1/m + d^2 / I),
// the box turns at j d / I. They part at once, so that only rounding is left.
TEST(Restitution, TurnsABoxThatIsHitOffItsCentreAsTheClosedFormSays) {
    for (const SolverVariant method : bouncing_methods()) {
        for (const float e : {0.25F, 1.0F}) {
            SCOPED_TRACE(name_of(method) + ", e " + std::to_string(e));
            VariantScene s(weightless(method));
            BodyDef def;
            def.shape = Shape::box(Vec3(0.5F, 1.0F, 0.5F));
            def.mass = 2.0F;
            def.material.friction = 0.0F;
            s.add(def);
            s.sphere(Vec3(-1.2F, 0.6F, 0.0F), Vec3(3.0F, 0.0F, 0.0F), e, 1.5F);
            s.run(0.1F);
            const float inertia = 2.0F / 3.0F * (0.25F + 1.0F);
            const float d = 0.6F;
            const float j = (1.0F + e) * 3.0F / (1.0F / 1.5F + 1.0F / 2.0F + d * d / inertia);
            const BodyState box = s.scene.state(s.bodies[0]);
            // Projection pushes at a box that has turned by then, as far as in a substep.
            const float most = method == SolverVariant::kProjection ? 0.02F : 1.0e-4F;
            EXPECT_NEAR(box.velocity.x(), j / 2.0F, most);
            EXPECT_NEAR(box.angular_velocity.z(), -j * d / inertia, most);
            EXPECT_NEAR(s.scene.state(s.bodies[1]).velocity.x(), 3.0F - j / 1.5F, most);
        }
    }
}

// In a row of equal spheres an elastic impact goes through: the last one leaves with the speed of
// the first, all others stay. Newton's restitution row by row in one system cannot do that.
TEST(ImpulseMethod, HandsAnImpactOnThroughARowOfSpheres) {
    VariantScene s(weightless(SolverVariant::kImpulse));
    s.sphere(Vec3(-2.0F, 0.0F, 0.0F), Vec3(3.0F, 0.0F, 0.0F), 1.0F);
    for (int i = 0; i < 4; ++i) {
        s.sphere(Vec3(static_cast<float>(i), 0.0F, 0.0F), Vec3::Zero(), 1.0F);
    }
    s.run(0.5F);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(s.scene.state(s.bodies[i]).velocity.x(), 0.0F, 1.0e-4F) << i;
    }
    EXPECT_NEAR(s.scene.state(s.bodies[4]).velocity.x(), 3.0F, 1.0e-4F);
}

// The energy of a sphere that bounces without loss: the bounce keeps it by construction, free
// flight is exact, and floats round 1e-7 of 100 J/kg in each of 1200 steps.
TEST(Restitution, KeepsTheEnergyOfABounceWithoutLoss) {
    for (const SolverVariant method : row_methods()) {
        SCOPED_TRACE(name_of(method));
        VariantScene s(settings_of(method, 60));
        s.ground(0.0F, 1.0F);
        s.sphere(Vec3(0.0F, 5.5F, 0.0F), Vec3::Zero(), 1.0F);
        s.run(20.0F);
        const BodyState state = s.scene.state(s.bodies[0]);
        const float energy =
            0.5F * state.velocity.squaredNorm() + kGravity * (state.position.y() - 0.5F);
        EXPECT_NEAR(energy, kGravity * 5.0F, 0.005F * kGravity * 5.0F);
    }
}

}  // namespace
}  // namespace zoned::physics
