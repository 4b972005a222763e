// Conservation laws: the sums that free bodies must keep whatever happens between them.
#include "server/physics/scene/scene.h"
#include "server/physics/shapes/compound/inertia.h"
#include "tests/unit/physics/physics_test.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cfloat>

namespace zoned::physics {
namespace {

struct Known {
    BodyId id;
    Shape shape;
    float mass;
};

struct Momentum {
    Vec3d linear = Vec3d::Zero();
    Vec3d angular = Vec3d::Zero();
    double energy = 0.0;
    double size = 0.0;  // sum of the absolute terms: the scale of rounding errors
};

Momentum measure(const Scene& scene, const std::vector<Known>& bodies) {
    Momentum m;
    for (const Known& k : bodies) {
        const BodyState s = scene.state(k.id);
        const Eigen::Matrix3d r = s.orientation.toRotationMatrix().cast<double>();
        const Vec3d moments = principal_inertia(k.shape, k.mass).cast<double>();
        const Vec3d v = s.velocity.cast<double>();
        const Vec3d w = s.angular_velocity.cast<double>();
        const Vec3d spin = r * moments.cwiseProduct(r.transpose() * w);
        const Vec3d orbit = s.position.cast<double>().cross(k.mass * v);
        m.linear += k.mass * v;
        m.angular += orbit + spin;
        m.energy += 0.5 * k.mass * v.squaredNorm() + 0.5 * w.dot(spin);
        m.size += k.mass * v.norm() * (1.0 + s.position.norm()) + spin.norm();
    }
    return m;
}

Known put(Scene& scene,
          const Shape& shape,
          float mass,
          const Vec3& x,
          const Vec3& v,
          core::Rng& rng) {
    BodyDef def;
    def.shape = shape;
    def.mass = mass;
    def.position = x;
    def.velocity = v;
    def.orientation =
        Quat(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1)).normalized();
    def.angular_velocity = Vec3(rng.range(-2, 2), rng.range(-2, 2), rng.range(-2, 2));
    const auto id = scene.add(def);
    EXPECT_TRUE(id.ok());
    return {*id, shape, mass};
}

Shape any_shape(core::Rng& rng) {
    switch (rng.below(3)) {
        case 0:
            return Shape::sphere(rng.range(0.3F, 0.6F));
        case 1:
            return Shape::box(
                {rng.range(0.2F, 0.6F), rng.range(0.2F, 0.6F), rng.range(0.2F, 0.6F)});
        default:
            return Shape::capsule(rng.range(0.2F, 0.4F), rng.range(0.2F, 0.5F));
    }
}

/// Random pairs meet; friction and restitution are drawn too. Each impulse and each substep rounds
/// a handful of times, with relative error eps/2 of terms bounded by `size`. Over n roundings of
/// random sign the sum grows as sqrt(n). For n = 60 steps x 4 substeps x about 10 operations that
/// is 50 eps; 200 eps leaves room for errors that do not average out.
void collide_pairs(float friction, float restitution) {
    core::Rng rng(17, static_cast<std::uint64_t>(friction * 10 + restitution * 100));
    int met = 0;
    for (int trial = 0; trial < 120; ++trial) {
        Scene scene(weightless());
        std::vector<Known> bodies;
        for (const float side : {-1.0F, 1.0F}) {
            BodyDef def;
            const Vec3 x(side * 1.5F, rng.range(-0.3F, 0.3F), rng.range(-0.3F, 0.3F));
            const Vec3 v(-side * rng.range(0.5F, 6.0F), rng.range(-0.5F, 0.5F), 0.0F);
            def.shape = any_shape(rng);
            def.mass = rng.range(0.5F, 5.0F);
            def.position = x;
            def.velocity = v;
            def.material = {friction, restitution};
            def.orientation =
                Quat(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1))
                    .normalized();
            def.angular_velocity = Vec3(rng.range(-2, 2), rng.range(-2, 2), rng.range(-2, 2));
            def.user = 1;
            const auto id = scene.add(def);
            ASSERT_TRUE(id.ok());
            bodies.push_back({*id, def.shape, def.mass});
        }
        const Momentum before = measure(scene, bodies);
        bool touched = false;
        for (int i = 0; i < 60; ++i) {
            scene.step(1.0F / 30.0F);
            touched |= !scene.contact_events().empty();
        }
        met += touched ? 1 : 0;
        const Momentum after = measure(scene, bodies);
        const double bound = 200.0 * FLT_EPSILON * std::max(before.size, after.size);
        EXPECT_LT((after.linear - before.linear).norm(), bound) << trial;
        EXPECT_LT((after.angular - before.angular).norm(), bound) << trial;
    }
    EXPECT_GT(met, 60);  // otherwise nothing was tested
}

TEST(Collision, ConservesMomentumWithoutFrictionAndBounce) {
    collide_pairs(0.0F, 0.0F);
}

TEST(Collision, ConservesMomentumWithFriction) {
    collide_pairs(0.8F, 0.0F);
}

TEST(Collision, ConservesMomentumWithHalfABounce) {
    collide_pairs(0.0F, 0.5F);
}

TEST(Collision, ConservesMomentumWithFullBounceAndFriction) {
    collide_pairs(0.8F, 1.0F);
}

TEST(Collision, OfManyBodiesConservesMomentum) {
    core::Rng rng(5);
    Scene scene(weightless());
    std::vector<Known> bodies;
    for (int i = 0; i < 64; ++i) {
        const Vec3 x(static_cast<float>(i % 4) * 1.6F - 2.4F,
                     static_cast<float>((i / 4) % 4) * 1.6F - 2.4F,
                     static_cast<float>(i / 16) * 1.6F - 2.4F);
        bodies.push_back(put(scene, any_shape(rng), rng.range(0.5F, 5.0F), x, -1.5F * x, rng));
    }
    const Momentum before = measure(scene, bodies);
    std::uint32_t contacts = 0;
    for (int i = 0; i < 90; ++i) {
        contacts += scene.step(1.0F / 30.0F).contacts;
    }
    const Momentum after = measure(scene, bodies);
    EXPECT_GT(contacts, 1000U);
    const double bound = 200.0 * FLT_EPSILON * before.size;
    EXPECT_LT((after.linear - before.linear).norm(), bound);
    EXPECT_LT((after.angular - before.angular).norm(), bound);
    EXPECT_LT(after.energy, before.energy);
}

TEST(FreeBody, KeepsItsVelocityExactly) {
    Scene scene(weightless());
    BodyDef def;
    def.shape = Shape::sphere(0.5F);
    def.velocity = Vec3(1.1F, -2.3F, 0.7F);
    def.angular_velocity = Vec3(3.0F, 0.1F, -0.4F);
    const BodyId id = *scene.add(def);
    for (int i = 0; i < 300; ++i) {
        scene.step(1.0F / 30.0F);
    }
    EXPECT_EQ(scene.state(id).velocity, def.velocity);
    EXPECT_EQ(scene.state(id).angular_velocity, def.angular_velocity);
}

TEST(FreeBody, FallsAlongTheExactParabola) {
    PhysicsSettings s;
    s.sleep_after_s = 0.0F;
    Scene scene(s);
    BodyDef def;
    def.shape = Shape::box(Vec3(0.3F, 0.4F, 0.5F));
    def.position = Vec3(0, 50, 0);
    def.velocity = Vec3(3, 5, -2);
    const BodyId id = *scene.add(def);
    constexpr int kSteps = 60;
    for (int i = 0; i < kSteps; ++i) {
        scene.step(1.0F / 30.0F);
    }
    const double t = kSteps / 30.0;
    const Vec3d exact(3 * t, 50 + 5 * t - 0.5 * 9.81 * t * t, -2 * t);
    // The scheme has no error of the step's own here (semi-implicit Euler would be g t dt / 8 =
    // 0.08 m off). 240 substeps round positions of 50 m (eps/2 each, at random sign) to about 5e-5.
    EXPECT_LT((scene.state(id).position.cast<double>() - exact).norm(), 3e-4);
}

TEST(FreeBody, SpinsWithConstantAngularMomentumAndBoundedEnergy) {
    // The intermediate axis: the hardest spin, it tumbles over and over.
    Scene scene(weightless());
    core::Rng rng(1);
    BodyDef def;
    def.shape = Shape::box(Vec3(0.5F, 1.0F, 1.5F));
    def.mass = 6.0F;
    def.angular_velocity = Vec3(0.01F, 5.0F, 0.01F);
    const std::vector<Known> bodies{{*scene.add(def), def.shape, def.mass}};
    const Momentum before = measure(scene, bodies);
    double worst = 0.0;
    for (int i = 0; i < 1800; ++i) {
        scene.step(1.0F / 30.0F);
        worst = std::max(worst, std::abs(measure(scene, bodies).energy / before.energy - 1.0));
    }
    const Momentum after = measure(scene, bodies);
    // 7200 substeps with some 30 roundings each, at random sign: sqrt(2e5) eps / 2 = 3e-5.
    EXPECT_LT((after.angular - before.angular).norm(), 1e-4 * before.angular.norm());
    // Second order with w h = 5 / 120: (w h)^2 = 0.0017 sets the scale.
    EXPECT_LT(worst, 0.01);
}

TEST(FreeBody, DoesNotBlowUpWhenItSpinsWildly) {
    Scene scene(weightless());
    BodyDef def;
    def.shape = Shape::box(Vec3(0.02F, 0.5F, 0.1F));
    def.angular_velocity = Vec3(60.0F, 40.0F, 80.0F);
    const std::vector<Known> bodies{{*scene.add(def), def.shape, def.mass}};
    const Momentum before = measure(scene, bodies);
    for (int i = 0; i < 900; ++i) {
        scene.step(1.0F / 30.0F);
        const Momentum now = measure(scene, bodies);
        // Pieces of second order in turns of at most an eighth of a radian: the energy swings by
        // a fraction of 0.125^2 of itself with the phase of the tumble, and does not drift.
        ASSERT_LT((now.angular - before.angular).norm(), 1e-3 * before.angular.norm()) << i;
        ASSERT_NEAR(now.energy / before.energy, 1.0, 0.005) << i;
    }
}

}  // namespace
}  // namespace zoned::physics
