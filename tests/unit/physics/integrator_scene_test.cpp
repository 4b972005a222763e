// Integrators in a scene: projectiles end where the chosen method's theory says, contacts stay.
#include "server/physics/integrator/stability.h"
#include "server/physics/scene/scene.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/physics/physics_test.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace zoned::physics {
namespace {

constexpr int kFlightSteps = 120;
constexpr double kAirDrag = 1.5;

PhysicsSettings flown_by(IntegratorKind kind) {
    PhysicsSettings settings;
    settings.body_integrator = kind;
    settings.particle_integrator = kind;
    return settings;
}

bool in_scenes(IntegratorKind kind) {
    return why_unfit_integrator(kind).empty();
}

/// The share of the velocity that remains after one step of v' = -c v by the method's own formula,
/// c h = s.
double left_of_speed(IntegratorKind kind, double s) {
    switch (kind) {
        case IntegratorKind::kExplicitEuler:
        case IntegratorKind::kSemiImplicitEuler:
            return 1 - s;
        case IntegratorKind::kVelocityVerlet:
        case IntegratorKind::kRk2:
            return 1 - s + s * s / 2;
        case IntegratorKind::kRk4:
            return 1 - s + s * s / 2 - s * s * s / 6 + s * s * s * s / 24;
        case IntegratorKind::kAdaptive:
            return std::exp(-s);
        default:
            return 1 / (1 + s);
    }
}

BodyState thrown(IntegratorKind kind, BodyKind body, float drag) {
    Scene scene{flown_by(kind)};
    BodyDef def;
    def.kind = body;
    def.shape = Shape::sphere(0.1F);
    def.position = Vec3(1, 2, 3);
    def.velocity = Vec3(3, 20, -2);
    def.damping.linear = drag;
    const BodyId id = *scene.add(def);
    run_steps(scene, kFlightSteps);
    return scene.state(id);
}

/// Floats: 120 steps round positions and velocities of up to 22 by half an ulp, 1e-6, each.
constexpr double kFloatRounding = 1.2e-4;

class Thrown : public testing::TestWithParam<BodyKind> {};

TEST_P(Thrown, LandsWhereTheMethodsTheorySays) {
    const auto h = static_cast<double>(kFrame);
    const double t = kFlightSteps * h;
    for (const IntegratorKind kind : kIntegratorKinds) {
        if (!in_scenes(kind)) {
            continue;
        }
        double off = 0.0;
        if (kind == IntegratorKind::kExplicitEuler) {
            off = 0.5 * 9.81 * h * t;
        } else if (kind == IntegratorKind::kImplicitEuler ||
                   kind == IntegratorKind::kSemiImplicitEuler) {
            off = -0.5 * 9.81 * h * t;
        }
        const BodyState end = thrown(kind, GetParam(), 0.0F);
        const Vec3d exact(1 + 3 * t, 2 + 20 * t - 0.5 * 9.81 * t * t + off, 3 - 2 * t);
        EXPECT_LT((end.position.cast<double>() - exact).norm(), kFloatRounding) << name_of(kind);
        EXPECT_NEAR(static_cast<double>(end.velocity.y()), 20 - 9.81 * t, kFloatRounding)
            << name_of(kind);
    }
}

TEST_P(Thrown, IsBrakedByDragAsTheMethodsTheorySays) {
    const auto h = static_cast<double>(kFrame);
    for (const IntegratorKind kind : kIntegratorKinds) {
        if (!in_scenes(kind)) {
            continue;
        }
        const double left = std::pow(left_of_speed(kind, kAirDrag * h), kFlightSteps);
        const double terminal = -9.81 / kAirDrag;
        const BodyState end = thrown(kind, GetParam(), static_cast<float>(kAirDrag));
        // The adaptive pair may be off by its tolerance, 1e-6 of 20 m/s, in each step.
        EXPECT_NEAR(static_cast<double>(end.velocity.x()), 3 * left, kFloatRounding)
            << name_of(kind);
        EXPECT_NEAR(static_cast<double>(end.velocity.y()),
                    terminal + (20 - terminal) * left,
                    kFloatRounding)
            << name_of(kind);
    }
}

INSTANTIATE_TEST_SUITE_P(Integrators,
                         Thrown,
                         testing::Values(BodyKind::kDynamic, BodyKind::kParticle),
                         [](const testing::TestParamInfo<BodyKind>& which) {
                             return which.param == BodyKind::kDynamic ? std::string("body")
                                                                      : std::string("particle");
                         });

TEST(SceneIntegrator, RefusesVerletWithTheReason) {
    EXPECT_NE(why_unfit_integrator(IntegratorKind::kVerlet).find("velocity_verlet"),
              std::string::npos);
    EXPECT_NE(why_unfit_integrator(static_cast<IntegratorKind>(99)), "");
    EXPECT_DEATH(Scene{flown_by(IntegratorKind::kVerlet)}, "integrator");
}

/// Particles that fall on the ground bounce, slide and come to rest with any method; bodies in
/// contact belong to the solver.
TEST(SceneIntegrator, LetsWhatFallsComeToRest) {
    for (const IntegratorKind kind : kIntegratorKinds) {
        if (!in_scenes(kind)) {
            continue;
        }
        Scene scene{flown_by(kind)};
        BodyDef ground;
        ground.kind = BodyKind::kStatic;
        ground.shape = Shape::plane();
        ASSERT_TRUE(scene.add(ground).ok());
        BodyDef def;
        def.shape = Shape::box({0.5F, 0.5F, 0.5F});
        def.position = Vec3(0, 3, 0);
        def.velocity = Vec3(2, 0, 0);
        def.material.restitution = 0.5F;
        const BodyId box = *scene.add(def);
        def.kind = BodyKind::kParticle;
        def.position = Vec3(20, 3, 0);
        const BodyId point = *scene.add(def);
        run_steps(scene, 30);
        const auto before = allocation_count();
        run_steps(scene, 10);
        EXPECT_EQ(allocation_count(), before);
        run_steps(scene, 560);
        EXPECT_TRUE(scene.state(box).asleep) << name_of(kind);
        EXPECT_TRUE(scene.state(point).asleep) << name_of(kind);
        EXPECT_NEAR(scene.state(box).position.y(), 0.5F, 0.01F) << name_of(kind);
        EXPECT_NEAR(scene.state(point).position.y(), 0.0F, 1e-3F) << name_of(kind);
        EXPECT_GT(scene.state(point).position.x(), 21.0F) << name_of(kind);
    }
}

/// A bounce turns the speed at the surface round. Half a step of gravity, 0.08 m/s, is the
/// uncertainty of methods of order one there.
TEST(SceneIntegrator, BouncesParticlesToTheSameHeight) {
    for (const IntegratorKind kind : kIntegratorKinds) {
        if (!in_scenes(kind)) {
            continue;
        }
        Scene scene{flown_by(kind)};
        BodyDef ground;
        ground.kind = BodyKind::kStatic;
        ground.shape = Shape::plane();
        ASSERT_TRUE(scene.add(ground).ok());
        BodyDef def;
        def.kind = BodyKind::kParticle;
        def.shape = Shape::sphere(0.1F);
        def.position = Vec3(0, 10, 0);
        def.material.restitution = 1.0F;
        const BodyId id = *scene.add(def);
        float top = 0.0F;
        bool up = false;
        for (int i = 0; i < 170; ++i) {
            scene.step(kFrame);
            const BodyState s = scene.state(id);
            up = up || s.velocity.y() > 0.0F;
            top = up ? std::max(top, s.position.y()) : top;
        }
        // d(v^2 / 2 g) = v dv / g with v = 14 m/s, twice (down and up) 0.08 m/s.
        EXPECT_NEAR(top, 10.0F, 14.0F * 0.16F / 9.81F + 0.01F) << name_of(kind);
    }
}

}  // namespace
}  // namespace zoned::physics
