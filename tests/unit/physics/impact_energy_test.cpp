// Impacts that once made energy: fast spins, glancing meetings, springs between a hammer and the
// ground. No restitution up to 1 leaves more energy than there was.
#include "tests/unit/physics/joint_scene.h"
#include "tests/unit/physics/physics_test.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace zoned::physics {
namespace {

/// Rounding of a hundred steps, as a share of the energy.
constexpr double kEnergyShare = 1.0e-3;

BodyDef moving(const Shape& shape, float mass, const Vec3& position, const Vec3& velocity) {
    BodyDef def;
    def.shape = shape;
    def.mass = mass;
    def.position = position;
    def.velocity = velocity;
    return def;
}

/// The most energy of motion and height after each of `steps`, as a share of that at the start.
double most_share(JointScene& s, int steps) {
    const double start = s.sums().energy;
    double most = 0.0;
    for (int i = 0; i < steps; ++i) {
        s.run(kFrame);
        most = std::max(most, s.sums().energy / start);
    }
    return most;
}

TEST(ImpactEnergy, OfABoxThatASphereMakesSpinFast) {
    for (const float speed : {18.45F, 60.0F, 184.5F}) {
        JointScene s;
        BodyDef ball = moving(Shape::sphere(0.3F), 1.0F, Vec3(1.5F, 0, 0), Vec3::Zero());
        ball.kind = BodyKind::kStatic;
        s.add(ball);
        BodyDef box = moving(Shape::box(Vec3(0.1F, 0.03F, 0.03F)),
                             1.0F,
                             Vec3(-1.5F, 0, 0),
                             Vec3(speed, 0.5F, -0.5F));
        box.orientation = Quat(0.7749821F, 0.49598762F, 0.3915802F, 0.007998514F);
        box.material.restitution = 1.0F;
        const BodyId id = s.add(box);
        EXPECT_LT(most_share(s, 20), 1.0 + kEnergyShare) << speed << " m/s";
        EXPECT_GT(s.scene.state(id).angular_velocity.norm(), 10.0F) << "they met off its centre";
    }
}

TEST(ImpactEnergy, OfSpheresThatMeetAtAGlance) {
    JointScene s;
    s.add(Shape::sphere(0.15F),
          1.0F,
          Vec3(-1.95F, 1.3F, -0.3F),
          Vec3(72.3F, -1, -0.6F),
          Vec3(5.3F, -2.85F, 7.4F));
    BodyDef other = moving(Shape::sphere(0.1F), 1.0F, Vec3(0.3F, 1.5F, -0.3F), Vec3::Zero());
    other.material.friction = 0.7F;
    const BodyId slow = s.add(other);
    EXPECT_LT(most_share(s, 6), 1.0 + kEnergyShare);
    EXPECT_GT(s.scene.state(slow).velocity.norm(), 1.0F) << "they met";
}

TEST(ImpactEnergy, OfALightPlateOnASpringBetweenAHammerAndTheGround) {
    JointScene s(kDown);
    BodyDef ground =
        moving(Shape::box(Vec3(50.0F, 1.0F, 50.0F)), 1.0F, Vec3(0, -1, 0), Vec3::Zero());
    ground.kind = BodyKind::kStatic;
    s.add(ground);
    s.add(Shape::sphere(0.2F), 100.0F, Vec3(-0.8F, 1.0F, -0.3F));
    BodyDef plate =
        moving(Shape::box(Vec3(0.2F, 0.02F, 0.2F)), 1.0F, Vec3(-0.9F, 0.5F, -0.1F), Vec3::Zero());
    plate.material.restitution = 1.0F;
    const BodyId light = s.add(plate);
    const BodyId above = s.add(Shape::sphere(0.3F), 1.0F, Vec3(-0.9F, 1.5F, -0.2F));
    JointDef spring;
    spring.kind = JointKind::kSpring;
    spring.a = light;
    spring.b = above;
    spring.anchor = Vec3(-1.0F, 0.5F, 0.0F);
    spring.anchor_b = Vec3(-1.0F, 1.5F, 0.0F);
    spring.spring_damping_ratio = 1.0F;
    s.join(spring);
    EXPECT_LT(most_share(s, 60), 1.0 + kEnergyShare);
}

}  // namespace
}  // namespace zoned::physics
