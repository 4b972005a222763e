// The rigid hull of a soft body: mass, motion and place are those of the nodes, down and up again.
#include "server/physics/shapes/compound/compound.h"
#include "tests/unit/soft/soft_test.h"

namespace zoned::physics::soft {
namespace {

SoftDef spinning_jelly() {
    SoftDef def = jelly();
    for (SoftNode& n : def.nodes) {
        n.velocity = Vec3(1, 0, 0) + Vec3(0.5F, 2, 1).cross(n.position - Vec3(0, 2, 0));
    }
    return def;
}

TEST(RigidHull, StepsDownAndUpWithoutAJump) {
    SoftBodies bodies(weightless_soft());
    const SoftId id = put(bodies, spinning_jelly());
    run(bodies, 10);
    const Momenta before = momenta(bodies, id);
    const Vec3 corner = bodies.position(id, 0);
    const RigidHull hull = bodies.step_down(id);
    run(bodies, 10);
    EXPECT_EQ(bodies.position(id, 0), corner);
    EXPECT_EQ(bodies.stats().rigid, 1U);
    EXPECT_LT(
        (static_cast<double>(hull.mass) * hull.velocity.cast<double>() - before.linear).norm(),
        1e-6 * before.size);
    // Put back where it was, nothing moves and both momenta stay.
    bodies.step_up(id, hull.position, Quat::Identity(), hull.velocity, hull.angular_velocity);
    EXPECT_LT((bodies.position(id, 0) - corner).norm(), 1e-6F);
    const Momenta after = momenta(bodies, id);
    EXPECT_LT((after.linear - before.linear).norm(), 1e-5 * before.size);
    EXPECT_LT((after.angular - before.angular).norm(), 1e-5 * before.size);
}

/// A box of nodes rests on the ground as its hull where it rested as itself. They differ by the
/// give of the one's contact and of the other's springs, under a millimetre each.
TEST(RigidHull, RestsWhereTheNodesRested) {
    SoftDef def = jelly();
    SoftBodies bodies(awake_soft());
    const SoftId id = put(bodies, def);
    Scene scene{PhysicsSettings{}};
    BodyDef ground;
    ground.kind = BodyKind::kStatic;
    ground.shape = Shape::plane();
    ASSERT_TRUE(scene.add(ground).ok());
    run(bodies, 600, &scene);
    const auto rigid = bodies.rigid_body(id);
    ASSERT_TRUE(rigid.ok()) << rigid.error();
    const auto body = scene.add(*rigid);
    ASSERT_TRUE(body.ok());
    bodies.step_down(id);
    run(bodies, 120, &scene);
    const BodyState now = scene.state(*body);
    EXPECT_LT((now.position - rigid->position).norm(), 2e-3F);
    EXPECT_LT(now.orientation.angularDistance(rigid->orientation), 2e-3F);
}

/// The moments of points about their centre of mass, in the order that the body's axes have.
TEST(RigidHull, HasTheMassTheTensorAndTheMotionOfTheNodes) {
    SoftBodies bodies(weightless_soft());
    const SoftId id = put(bodies, spinning_jelly());
    run(bodies, 10);
    const Momenta nodes = momenta(bodies, id);
    const auto rigid = bodies.rigid_body(id);
    ASSERT_TRUE(rigid.ok()) << rigid.error();
    PhysicsSettings settings;
    settings.gravity.setZero();
    Scene scene(settings);
    const auto body = scene.add(*rigid);
    ASSERT_TRUE(body.ok());
    const BodyState state = scene.state(*body);
    const Mat3 axes = state.orientation.toRotationMatrix();
    const Vec3 moments = rigid->mass * compound_of(rigid->shape).moments_per_kg();
    const Vec3d linear = static_cast<double>(rigid->mass) * state.velocity.cast<double>();
    const Vec3 spin = axes * moments.cwiseProduct(Vec3(axes.transpose() * state.angular_velocity));
    const Vec3d angular = state.position.cast<double>().cross(linear) + spin.cast<double>();
    // Floats of sums of some hundred terms: a few hundred roundings of 2^-24 of the terms' sizes.
    EXPECT_LT((linear - nodes.linear).norm(), 1e-5 * nodes.size);
    EXPECT_LT((angular - nodes.angular).norm(), 1e-5 * nodes.size);
}

/// Nodes in one line have no moment about it; those in one plane have the largest that is possible.
TEST(RigidHull, IsMadeOfARopeAndOfACloth) {
    SoftBodies bodies(weightless_soft());
    RopeDef rope;
    for (const SoftDef& def : {*build_rope(rope), cloth(12)}) {
        const SoftId id = put(bodies, def);
        const auto rigid = bodies.rigid_body(id);
        ASSERT_TRUE(rigid.ok()) << rigid.error();
        Scene scene{PhysicsSettings{}};
        const auto body = scene.add(*rigid);
        ASSERT_TRUE(body.ok()) << body.error();
        for (int i = 0; i < 120; ++i) {
            scene.step(kFrame);
        }
        // Exactly: there are no obstacles, and constant acceleration is integrated exactly.
        EXPECT_NEAR(
            scene.state(*body).position.y() - rigid->position.y(), -0.5F * kGravity * 4.0F, 1e-3F);
    }
}

}  // namespace
}  // namespace zoned::physics::soft
