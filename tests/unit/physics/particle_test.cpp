// Particles: paths, bounces, friction, rest, and the change from body to particle and back.
#include "server/physics/scene/scene.h"
#include "server/physics/shapes/mesh.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/physics/physics_test.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace zoned::physics {
namespace {

BodyDef particle(const Vec3& x, const Vec3& v = Vec3::Zero()) {
    BodyDef def;
    def.kind = BodyKind::kParticle;
    def.shape = Shape::sphere(0.5F);
    def.position = x;
    def.velocity = v;
    return def;
}

BodyDef ground(float friction = 0.5F) {
    BodyDef def;
    def.kind = BodyKind::kStatic;
    def.shape = Shape::plane();
    def.material.friction = friction;
    return def;
}

TEST(Particle, FliesAlongTheParabola) {
    Scene scene{PhysicsSettings()};
    const BodyId id = *scene.add(particle(Vec3(1, 2, 3), Vec3(3, 20, -2)));
    run_steps(scene, 120);
    const double t = 2.0;
    const Vec3d exact(1 + 3 * t, 2 + 20 * t - 0.5 * 9.81 * t * t, 3 - 2 * t);
    // The scheme is exact, and dt rounds (6e-8 of it). Velocities up to 20 m/s and positions up to
    // 22 m round in 120 steps by half an ulp each at random sign: below 120 x 1e-6.
    EXPECT_LT((scene.state(id).position.cast<double>() - exact).norm(), 1.5e-4);
}

TEST(Particle, RisesToTheSquareOfTheRestitutionAfterABounce) {
    Scene scene{PhysicsSettings()};
    ASSERT_TRUE(scene.add(ground()).ok());
    BodyDef def = particle(Vec3(0, 10, 0));
    def.material.restitution = 0.8F;
    const BodyId id = *scene.add(def);
    float apex[3]{};
    int bounces = 0;
    float before = -1.0F;
    for (int i = 0; i < 460 && bounces < 3; ++i) {
        scene.step(kFrame);
        const BodyState s = scene.state(id);
        bounces += before < 0.0F && s.velocity.y() > 0.0F ? 1 : 0;
        before = s.velocity.y();
        if (bounces > 0 && bounces < 3) {
            // The top of the parabola that it is on.
            const float top = s.position.y() + s.velocity.y() * s.velocity.y() / (2 * 9.81F);
            apex[bounces] = s.velocity.y() > 0.0F ? top : apex[bounces];
        }
    }
    EXPECT_NEAR(apex[1], 6.4F, 1e-4F);
    EXPECT_NEAR(apex[2], 4.096F, 2e-4F);
}

TEST(Particle, NeverPassesThroughThinWalls) {
    PhysicsSettings settings;
    settings.gravity.setZero();
    Scene scene{settings};
    BodyDef wall;
    wall.kind = BodyKind::kStatic;
    wall.shape = Shape::box({0.001F, 50, 50});
    ASSERT_TRUE(scene.add(wall).ok());
    wall.position.x() = 20;
    ASSERT_TRUE(scene.add(wall).ok());
    std::vector<BodyId> ids;
    core::Rng rng(3);
    for (int i = 0; i < 500; ++i) {
        BodyDef def = particle(Vec3(10, rng.range(-5, 5), rng.range(-5, 5)),
                               Vec3(rng.range(-2000, 2000), rng.range(-1, 1), rng.range(-1, 1)));
        def.material.restitution = 1.0F;
        ids.push_back(*scene.add(def));
    }
    run_steps(scene, 120);
    for (const BodyId id : ids) {
        EXPECT_GT(scene.state(id).position.x(), 0.0F);
        EXPECT_LT(scene.state(id).position.x(), 20.0F);
    }
}

TEST(Particle, NeverPassesThroughAMeshOfManyTriangles) {
    std::vector<Vec3> vertices;
    std::vector<std::uint32_t> indices;
    constexpr int kN = 24;
    core::Rng rng(9);
    for (int k = 0; k <= kN; ++k) {
        for (int i = 0; i <= kN; ++i) {
            vertices.emplace_back(
                static_cast<float>(i) - 12.0F, rng.range(0, 1.5F), static_cast<float>(k) - 12.0F);
        }
    }
    for (std::uint32_t k = 0; k < kN; ++k) {
        for (std::uint32_t i = 0; i < kN; ++i) {
            const std::uint32_t a = k * (kN + 1) + i;
            const std::uint32_t c = a + kN + 1;
            indices.insert(indices.end(), {a, c, c + 1, a, c + 1, a + 1});
        }
    }
    Scene scene{PhysicsSettings()};
    BodyDef terrain;
    terrain.kind = BodyKind::kStatic;
    terrain.shape = Shape::mesh(build_mesh(vertices, indices).value().mesh);
    ASSERT_TRUE(scene.add(terrain).ok());
    std::vector<BodyId> ids;
    for (int i = 0; i < 400; ++i) {
        BodyDef def = particle(Vec3(rng.range(-8, 8), 3, rng.range(-8, 8)),
                               Vec3(rng.range(-3, 3), rng.range(-300, 0), rng.range(-3, 3)));
        def.material.restitution = i % 2 == 0 ? 0.5F : 0.0F;
        ids.push_back(*scene.add(def));
    }
    run_steps(scene, 300);
    int inside = 0;
    for (const BodyId id : ids) {
        const BodyState s = scene.state(id);
        if (std::abs(s.position.x()) < 12.0F && std::abs(s.position.z()) < 12.0F) {
            ++inside;
            EXPECT_GT(s.position.y(), -0.001F);
        }
    }
    EXPECT_GT(inside, 100);
}

TEST(Particle, SlidesDownAnInclineAsFrictionSays) {
    Scene scene{PhysicsSettings()};
    const float a = 0.5235988F;
    BodyDef slope = ground(0.3F);
    slope.orientation = Quat(Eigen::AngleAxisf(-a, Vec3::UnitZ()));
    ASSERT_TRUE(scene.add(slope).ok());
    BodyDef def = particle(slope.orientation * Vec3(0, 1e-4F, 0));
    def.material.friction = 0.3F;
    const BodyId id = *scene.add(def);
    run_steps(scene, 120);
    // (g sin a - mu g cos a) t^2 / 2; it first falls the tenth of a millimetre onto the slope.
    const float expected = (0.5F - 0.3F * 0.8660254F) * 9.81F * 0.5F * 4.0F;
    EXPECT_NEAR(scene.state(id).position.norm(), expected, 0.01F);
}

TEST(Particle, SleepsOnTheGroundAndWakesWhenItGoes) {
    Scene scene{PhysicsSettings()};
    BodyDef slab = ground();
    slab.shape = Shape::box({2, 0.5F, 2});
    slab.position = Vec3(0, -0.5F, 0);
    const BodyId floor = *scene.add(slab);
    const BodyId id = *scene.add(particle(Vec3(0, 1, 0)));
    run_steps(scene, 90);
    ASSERT_TRUE(scene.state(id).asleep);
    EXPECT_NEAR(scene.state(id).position.y(), 0.0F, 1e-4F);
    EXPECT_TRUE(scene.step(kFrame).skipped);
    scene.remove(floor);
    scene.step(kFrame);
    EXPECT_FALSE(scene.state(id).asleep);
    EXPECT_LT(scene.state(id).velocity.y(), 0.0F);
}

TEST(Particle, IsCarriedByALiftAndWokenByIt) {
    Scene scene{PhysicsSettings()};
    BodyDef lift;
    lift.kind = BodyKind::kKinematic;
    lift.shape = Shape::box({2, 0.1F, 2});
    lift.position = Vec3(0, -2, 0);
    const BodyId id_lift = *scene.add(lift);
    BodyDef slab = ground();
    slab.shape = Shape::box({0.05F, 0.5F, 0.05F});
    slab.position = Vec3(0, -0.5F, 0);
    ASSERT_TRUE(scene.add(slab).ok());
    const BodyId id = *scene.add(particle(Vec3(0, 0.01F, 0)));
    const BodyId beside = *scene.add(particle(Vec3(1, 0.5F, 0)));
    run_steps(scene, 60);
    ASSERT_TRUE(scene.state(id).asleep);
    scene.set_velocity(id_lift, Vec3(0, 3, 0), Vec3::Zero());
    run_steps(scene, 120);  // now at y = 4
    EXPECT_NEAR(scene.state(id).position.y(), 4.1F, 0.1F);
    EXPECT_NEAR(scene.state(beside).position.y(), 4.1F, 0.1F);
    EXPECT_NEAR(scene.state(id).velocity.y(), 3.0F, 0.3F);
}

TEST(Particle, TurnsIntoABodyAndBackWithItsMomentum) {
    PhysicsSettings settings;
    settings.gravity.setZero();
    Scene scene{settings};
    BodyDef def;
    def.shape = Shape::box({0.3F, 0.2F, 0.1F});
    def.mass = 3.0F;
    def.user = 77;
    def.velocity = Vec3(1, 2, 3);
    def.angular_velocity = Vec3(0, 1, 0);
    const BodyId id = *scene.add(def);
    ASSERT_TRUE(scene.set_representation(id, BodyRepresentation::kParticle).ok());
    const Quat frozen = scene.state(id).orientation;
    run_steps(scene, 30);
    EXPECT_EQ(scene.state(id).orientation.coeffs(), frozen.coeffs());
    EXPECT_EQ(scene.state(id).velocity, def.velocity);
    EXPECT_EQ(scene.user(id), 77U);
    scene.apply_impulse(id, Vec3(3, 0, 0), Vec3(5, 5, 5));
    EXPECT_EQ(scene.state(id).velocity, Vec3(2, 2, 3));
    ASSERT_TRUE(scene.set_representation(id, BodyRepresentation::kFull).ok());
    EXPECT_EQ(scene.state(id).velocity, Vec3(2, 2, 3));
    EXPECT_EQ(scene.state(id).angular_velocity, def.angular_velocity);
    run_steps(scene, 1);
    EXPECT_NE(scene.state(id).orientation.coeffs(), frozen.coeffs());
}

TEST(Particle, IsLiftedOutOfTheGroundWhenItBecomesABody) {
    Scene scene{PhysicsSettings()};
    ASSERT_TRUE(scene.add(ground()).ok());
    BodyDef def = particle(Vec3(0, 1, 0));
    def.shape = Shape::box({0.5F, 0.5F, 0.5F});
    const BodyId id = *scene.add(def);
    run_steps(scene, 90);
    ASSERT_LT(scene.state(id).position.y(), 0.01F);
    const auto state = scene.set_representation(id, BodyRepresentation::kFull);
    ASSERT_TRUE(state.ok());
    EXPECT_NEAR(state->position.y(), 0.5F, 1e-3F);
    run_steps(scene, 120);
    EXPECT_TRUE(scene.state(id).asleep);
    EXPECT_NEAR(scene.state(id).position.y(), 0.5F, 0.01F);
}

TEST(Particle, RefusesToBeWhatHasJointsOrNoMass) {
    Scene scene{PhysicsSettings()};
    const BodyId floor = *scene.add(ground());
    EXPECT_FALSE(scene.set_representation(floor, BodyRepresentation::kParticle).ok());
    EXPECT_FALSE(scene.set_representation(BodyId(), BodyRepresentation::kParticle).ok());
    BodyDef def = particle(Vec3(0, 5, 0));
    def.sensor = true;
    EXPECT_FALSE(scene.add(def).ok());
    def.sensor = false;
    def.kind = BodyKind::kDynamic;
    const BodyId held = *scene.add(def);
    JointDef joint;
    joint.b = held;
    ASSERT_TRUE(scene.add_joint(joint).ok());
    EXPECT_FALSE(scene.set_representation(held, BodyRepresentation::kParticle).ok());
}

TEST(Particle, HasTheSameHashInEachRunAndAllocatesNothing) {
    std::uint64_t hash[2];
    for (std::uint64_t& h : hash) {
        Scene scene{PhysicsSettings()};
        ASSERT_TRUE(scene.add(ground()).ok());
        core::Rng rng(4);
        for (int i = 0; i < 300; ++i) {
            BodyDef def = particle(Vec3(rng.range(-9, 9), rng.range(0.1F, 5), rng.range(-9, 9)),
                                   Vec3(rng.range(-9, 9), rng.range(-9, 9), rng.range(-9, 9)));
            def.material.restitution = 0.6F;
            ASSERT_TRUE(scene.add(def).ok());
        }
        const BodyId removed = *scene.add(particle(Vec3(0, 1, 0)));
        run_steps(scene, 30);
        scene.remove(removed);
        const auto before = allocation_count();
        run_steps(scene, 30);
        EXPECT_EQ(allocation_count(), before);
        run_steps(scene, 300);
        core::StateHash state;
        scene.hash(state);
        h = state.value();
    }
    EXPECT_EQ(hash[0], hash[1]);
}

}  // namespace
}  // namespace zoned::physics
