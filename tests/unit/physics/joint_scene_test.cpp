// The promises of a Scene about joints: refusals, removal, breaking, sleep, filters, determinism.
#include "tests/unit/physics/joint_scene.h"

#include "tests/unit/allocation_count.h"
#include "tests/unit/physics/physics_test.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::physics {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
const Shape kLink = Shape::box(Vec3(0.4F, 0.1F, 0.1F));

/// Links end to end along x from `anchor` (none: the world's origin).
std::vector<BodyId> add_chain(JointScene& s, int count, BodyId anchor, const Vec3& start) {
    std::vector<BodyId> links;
    BodyId before = anchor;
    for (int i = 0; i < count; ++i) {
        const Vec3 end = start + Vec3(static_cast<float>(i), 0, 0);
        const BodyId link = s.add(kLink, 1.0F, end + Vec3(0.5F, 0, 0));
        s.join(joint_of(JointKind::kBall, before, link, end));
        links.push_back(link);
        before = link;
    }
    return links;
}

TEST(AddJoint, RefusesEachMistakeWithItsOwnMessage) {
    JointScene s(kDown);
    const BodyId a = s.add(kLink, 1.0F, Vec3(0, 5, 0));
    const BodyId b = s.add(kLink, 1.0F, Vec3(1, 5, 0));
    BodyDef def;
    def.kind = BodyKind::kStatic;
    const BodyId wall = s.add(def);
    def.kind = BodyKind::kKinematic;
    def.position = Vec3(9, 9, 9);
    const BodyId lift = s.add(def);
    const BodyId gone = s.add(kLink, 1.0F, Vec3(3, 5, 0));
    s.scene.remove(gone);
    const auto why = [&](auto&& spoil) {
        JointDef joint = joint_of(JointKind::kHinge, a, b, Vec3(0.5F, 5, 0));
        spoil(joint);
        const auto result = s.scene.add_joint(joint);
        return result.ok() ? std::string() : result.error();
    };
    EXPECT_EQ(why([&](JointDef& j) { j.b = gone; }), "joint: no such body");
    EXPECT_EQ(why([&](JointDef& j) { j.a = gone; }), "joint: no such body");
    EXPECT_EQ(why([&](JointDef& j) { j.b = BodyId(); }), "joint: no such body");
    EXPECT_EQ(why([&](JointDef& j) { j.a = b; }), "joint: a body cannot be joined to itself");
    const std::string still = "joint: neither body is dynamic";
    EXPECT_EQ(why([&](JointDef& j) { j.a = wall, j.b = lift; }), still);
    EXPECT_EQ(why([&](JointDef& j) { j.a = BodyId(), j.b = lift; }), still);
    EXPECT_EQ(why([](JointDef& j) { j.kind = static_cast<JointKind>(99); }), "unknown joint kind");
    const std::string anchor = "joint: anchor out of range";
    EXPECT_EQ(why([](JointDef& j) { j.anchor.y() = kNan; }), anchor);
    EXPECT_EQ(why([](JointDef& j) { j.anchor_b.z() = kInf; }), anchor);
    const std::string axis = "joint: axis has no direction";
    EXPECT_EQ(why([](JointDef& j) { j.axis.setZero(); }), axis);
    EXPECT_EQ(why([](JointDef& j) { j.axis.x() = kNan; }), axis);
    EXPECT_EQ(why([](JointDef& j) { j.length_m = kNan; }), "joint: length out of range");
    const std::string spring = "joint: spring frequency or damping out of range";
    EXPECT_EQ(why([](JointDef& j) { j.spring_hz = -1.0F; }), spring);
    EXPECT_EQ(why([](JointDef& j) { j.spring_damping_ratio = kInf; }), spring);
    const auto limit = [&](float lower, float upper) {
        return why([&](JointDef& j) { j.limited = true, j.lower = lower, j.upper = upper; });
    };
    EXPECT_EQ(limit(1.0F, -1.0F), "joint: lower limit above the upper one");
    EXPECT_EQ(limit(kNan, 1.0F), "joint: limit out of range");
    EXPECT_EQ(limit(-kInf, -kInf), "joint: limit out of range");
    EXPECT_EQ(limit(4.0F, 5.0F), "joint: limit out of range");  // a hinge knows angles up to pi
    const std::string motor = "joint: motor speed or greatest force out of range";
    EXPECT_EQ(why([](JointDef& j) { j.motor = true, j.motor_speed = kNan; }), motor);
    EXPECT_EQ(why([](JointDef& j) { j.motor = true, j.motor_max = -1.0F; }), motor);
    const std::string force = "joint: force to break at must be positive";
    EXPECT_EQ(why([](JointDef& j) { j.break_force_n = 0.0F; }), force);
    EXPECT_EQ(why([](JointDef& j) { j.break_force_n = kNan; }), force);
    // None of them left anything behind, and a good one is taken.
    EXPECT_EQ(why([](JointDef&) {}), "");
    EXPECT_TRUE(s.scene.step(kFrame).quarantined == 0);
}

TEST(SetMotor, IgnoresWhatIsNotFinite) {
    JointScene s(Vec3::Zero());
    const BodyId b = s.add(kLink, 1.0F, Vec3::Zero());
    JointDef def = joint_of(JointKind::kHinge, BodyId(), b, Vec3::Zero());
    def.motor = true;
    def.motor_speed = 2.0F;
    def.motor_max = 100.0F;
    const JointId hinge = s.join(def);
    EXPECT_FALSE(s.scene.set_motor(hinge, kNan, 1.0F));
    EXPECT_FALSE(s.scene.set_motor(hinge, 1.0F, kNan));
    EXPECT_FALSE(s.scene.set_motor(hinge, 1.0F, -1.0F));
    s.run(1.0F);
    EXPECT_NEAR(s.scene.state(b).angular_velocity.y(), 2.0F, 1e-4F);
    EXPECT_TRUE(s.scene.set_motor(hinge, -3.0F, 100.0F));
    s.run(1.0F);
    EXPECT_NEAR(s.scene.state(b).angular_velocity.y(), -3.0F, 1e-4F);
}

TEST(RemovalOfABody, TakesItsJointsWithItAndLetsTheRestGo) {
    JointScene s(kDown);
    const auto links = add_chain(s, 3, BodyId(), Vec3(0, 5, 0));
    const JointId tip = s.join(joint_of(JointKind::kBall, links[1], links[2], Vec3(2, 5, 0)));
    s.run(0.2F);
    s.scene.remove(links[1]);
    EXPECT_FALSE(s.scene.contains(tip));
    const Vec3 before = s.scene.state(links[2]).velocity;
    s.run(0.5F);
    // Nothing holds the last link: it falls freely.
    EXPECT_NEAR(s.scene.state(links[2]).velocity.y(), before.y() - 0.5F * kGravity, 1e-3F);
    EXPECT_LT(s.scene.state(links[0]).position.norm(), 5.6F);
    // The row is taken by another body, which has no joints.
    const BodyId next = s.add(kLink, 1.0F, Vec3(0, 50, 0));
    s.run(0.5F);
    EXPECT_NEAR(s.scene.state(next).velocity.y(), -0.5F * kGravity, 1e-3F);
    s.scene.remove_joint(tip);  // gone already: nothing happens
}

TEST(RemovalOfAJoint, LetsGoAndNeverMakesOldIdsLiveAgain) {
    JointScene s(kDown);
    const BodyId b = s.add(kLink, 1.0F, Vec3(0, 5, 0));
    const JointDef def = joint_of(JointKind::kFixed, BodyId(), b, Vec3(0, 5, 0));
    const JointId first = s.join(def);
    s.run(1.0F);
    EXPECT_NEAR(s.scene.state(b).position.y(), 5.0F, 1e-4F);
    s.scene.remove_joint(first);
    const JointId second = s.join(def);
    EXPECT_NE(first, second);
    EXPECT_FALSE(s.scene.contains(first));
    EXPECT_TRUE(s.scene.contains(second));
    s.scene.remove_joint(second);
    s.run(0.5F);
    EXPECT_NEAR(s.scene.state(b).velocity.y(), -0.5F * kGravity, 1e-3F);
}

/// Steps until the joint breaks, or -1.
int breaks_after(float mass, float limit, JointBreak& seen) {
    JointScene s(kDown);
    const BodyId b = s.add(Shape::sphere(0.2F), mass, Vec3(0, 5, 0));
    JointDef def = joint_of(JointKind::kDistance, BodyId(), b, Vec3(0, 7, 0));
    def.anchor_b = Vec3(0, 5, 0);
    def.break_force_n = limit;
    def.user = 77;
    const JointId rope = s.join(def);
    for (int i = 1; i <= 120; ++i) {
        s.scene.step(kFrame);
        if (!s.scene.joint_breaks().empty()) {
            EXPECT_EQ(s.scene.joint_breaks().size(), 1U);
            seen = s.scene.joint_breaks()[0];
            EXPECT_EQ(seen.joint, rope);
            EXPECT_EQ(seen.b, b);
            EXPECT_FALSE(s.scene.contains(rope));
            s.scene.step(kFrame);
            EXPECT_TRUE(s.scene.joint_breaks().empty());
            return i;
        }
    }
    EXPECT_NEAR(s.scene.joint_force(rope), mass * kGravity, 1e-3F * mass * kGravity);
    return -1;
}

TEST(BreakForce, BreaksExactlyWhereTheLoadExceedsIt) {
    JointBreak seen;
    // 10 kg weigh 98.1 N. A rope that is taut at the start carries the weight at once.
    EXPECT_EQ(breaks_after(10.0F, 98.1F * 1.002F, seen), -1);
    EXPECT_EQ(breaks_after(10.0F, 98.1F * 0.998F, seen), 1);
    EXPECT_EQ(seen.user, 77U);
    EXPECT_NEAR(seen.force_n, 98.1F, 0.1F);
    EXPECT_EQ(breaks_after(1000.0F, 9810.0F * 1.002F, seen), -1);
    EXPECT_EQ(breaks_after(1000.0F, 9810.0F * 0.998F, seen), 1);
}

TEST(BreakForce, OfASwingIsThatAtItsLowestPoint) {
    // From level, a pendulum pulls with 3 m g at the bottom.
    for (const float share : {0.98F, 1.02F}) {
        JointScene s(kDown);
        const BodyId bob = s.add(Shape::sphere(0.02F), 2.0F, Vec3(1, 0, 0));
        JointDef def = joint_of(JointKind::kBall, BodyId(), bob, Vec3::Zero());
        def.break_force_n = share * 3.0F * 2.0F * kGravity;
        const JointId joint = s.join(def);
        s.run(3.0F);
        EXPECT_EQ(s.scene.contains(joint), share > 1.0F);
    }
}

BodyId add_floor(JointScene& s) {
    BodyDef def;
    def.kind = BodyKind::kStatic;
    def.shape = Shape::plane();
    return s.add(def);
}

TEST(Sleep, BodiesThatJointsHoldTogetherSleepAndWakeTogether) {
    JointScene s(kDown, true);
    add_floor(s);
    const auto links = add_chain(s, 5, BodyId(), Vec3(0, 0.1F, 0));
    const BodyId apart = s.add(kLink, 1.0F, Vec3(0, 0.1F, 5));
    s.run(5.0F);
    ASSERT_EQ(s.scene.awake_count(), 0U);
    s.scene.apply_impulse(links[4], Vec3(0, 2, 0), s.scene.state(links[4]).position);
    EXPECT_EQ(s.scene.awake_count(), 5U);
    EXPECT_TRUE(s.scene.state(apart).asleep);
    s.run(0.3F);
    // One of them moves: none may sleep.
    EXPECT_EQ(s.scene.awake_count(), 5U);
    s.run(10.0F);
    EXPECT_EQ(s.scene.awake_count(), 0U);
}

TEST(Sleep, AJointThatIsAddedOrRemovedWakesBoth) {
    JointScene s(kDown, true);
    add_floor(s);
    const BodyId a = s.add(kLink, 1.0F, Vec3(0, 0.1F, 0));
    const BodyId b = s.add(kLink, 1.0F, Vec3(1, 0.1F, 0));
    s.run(3.0F);
    ASSERT_EQ(s.scene.awake_count(), 0U);
    const JointId joint = s.join(joint_of(JointKind::kFixed, a, b, Vec3(0.5F, 0.1F, 0)));
    EXPECT_EQ(s.scene.awake_count(), 2U);
    s.run(3.0F);
    ASSERT_EQ(s.scene.awake_count(), 0U);
    s.scene.remove_joint(joint);
    EXPECT_EQ(s.scene.awake_count(), 2U);
}

TEST(JoinedBodies, CollideOnlyWhereAsked) {
    for (const bool collide : {false, true}) {
        JointScene s(Vec3::Zero());
        const Shape ball = Shape::sphere(0.5F);
        const BodyId a = s.add(ball, 1.0F, Vec3(0, 0, 0));
        const BodyId b = s.add(ball, 1.0F, Vec3(2, 0, 0), Vec3(-1, 0, 0));
        JointDef def = joint_of(JointKind::kSlider, a, b, Vec3::Zero());
        def.axis = Vec3::UnitX();
        def.collide = collide;
        s.join(def);
        s.run(1.5F);
        EXPECT_EQ(s.scene.state(a).velocity.x() < -0.1F, collide);
        s.run(1.5F);
        const float apart = s.scene.state(b).position.x() - s.scene.state(a).position.x();
        EXPECT_NEAR(apart, collide ? 1.0F : -1.0F, 0.02F);
    }
}

TEST(JoinedBodies, CollideAgainAfterTheJointIsGone) {
    JointScene s(kDown);
    add_floor(s);
    const BodyId lower = s.add(Shape::box(Vec3::Constant(0.5F)), 1.0F, Vec3(0, 0.5F, 0));
    const BodyId upper = s.add(Shape::box(Vec3::Constant(0.5F)), 1.0F, Vec3(0, 1.5F, 0));
    const JointId joint = s.join(joint_of(JointKind::kBall, lower, upper, Vec3(0, 1, 0)));
    s.run(0.1F);
    s.scene.remove_joint(joint);
    s.run(2.0F);
    EXPECT_NEAR(s.scene.state(upper).position.y(), 1.5F, 0.01F);
}

TEST(KinematicAnchor, DragsItsChainWhetherItSleepsOrNot) {
    for (const bool sleeping : {false, true}) {
        JointScene s(kDown, sleeping);
        BodyDef def;
        def.kind = BodyKind::kKinematic;
        def.shape = Shape::sphere(0.1F);
        def.position = Vec3(0, 20, 0);
        const BodyId anchor = s.add(def);
        std::vector<BodyId> links;
        for (int i = 0; i < 8; ++i) {  // hanging down at rest
            const Vec3 top(0, 20.0F - static_cast<float>(i), 0);
            links.push_back(
                s.add(Shape::box(Vec3(0.1F, 0.4F, 0.1F)), 1.0F, top - Vec3(0, 0.5F, 0)));
            const BodyId before = i == 0 ? anchor : links[static_cast<std::size_t>(i) - 1];
            s.join(joint_of(JointKind::kBall, before, links.back(), top));
        }
        s.run(2.0F);
        EXPECT_EQ(s.scene.awake_count(), sleeping ? 0U : 8U);
        s.scene.set_velocity(anchor, Vec3(3, 0, 0), Vec3::Zero());
        s.run(10.0F);
        EXPECT_NEAR(s.scene.state(anchor).position.x(), 30.0F, 0.01F);
        for (const BodyId link : links) {
            const Vec3 hangs = s.scene.state(link).position - s.scene.state(anchor).position;
            EXPECT_LT(hangs.norm(), 8.0F);
        }
        // And where the anchor is moved elsewhere at once, the chain follows without being lost.
        s.scene.set_velocity(anchor, Vec3::Zero(), Vec3::Zero());
        s.run(60.0F);
        BodyState state = s.scene.state(anchor);
        state.position += Vec3(0, 5, 0);
        s.scene.set_state(anchor, state);
        std::uint32_t quarantined = 0;
        for (int i = 0; i < 600; ++i) {
            quarantined += s.scene.step(kFrame).quarantined;
        }
        EXPECT_EQ(quarantined, 0U);
        EXPECT_LT((s.scene.state(links[0]).position - state.position).norm(), 0.6F);
    }
}

TEST(Teleport, OfAJoinedBodyFarAwayIsHealedWithinSightAndHarmsNobody) {
    JointScene s(Vec3::Zero());
    const auto links = add_chain(s, 4, BodyId(), Vec3::Zero());
    BodyState state = s.scene.state(links[3]);
    state.position += Vec3(30, 40, -20);
    state.orientation = Quat(0, 1, 0, 0);
    s.scene.set_state(links[3], state);
    std::uint32_t quarantined = 0;
    for (int i = 0; i < 600; ++i) {
        quarantined += s.scene.step(kFrame).quarantined;
        ASSERT_TRUE(s.sums().finite) << i;
        // It comes at 20 m/s along each axis, turning about its anchor.
        ASSERT_LT(s.scene.state(links[3]).velocity.norm(), 80.0F) << i;
    }
    EXPECT_EQ(quarantined, 0U);
    EXPECT_LT(s.scene.state(links[3]).position.norm(), 4.0F);
}

/// Chains, ragdoll-like trees, motors and limits that fall onto the floor and on each other.
std::vector<std::uint64_t> run_joints(int frames, bool count_allocations) {
    core::Rng rng(4);
    JointScene s(kDown);
    add_floor(s);
    for (int k = 0; k < 6; ++k) {
        const Vec3 at(rng.range(-1, 1), 1.5F + static_cast<float>(k), rng.range(-1, 1));
        const BodyId trunk = s.add(Shape::box(Vec3(0.3F, 0.4F, 0.2F)), 4.0F, at);
        for (int limb = 0; limb < 4; ++limb) {
            const Vec3 root = at + Vec3(limb % 2 == 0 ? -0.3F : 0.3F, limb < 2 ? 0.4F : -0.4F, 0);
            const Vec3 knee = root + 0.8F * (root - at);
            const BodyId thigh = s.add(Shape::capsule(0.1F, 0.1F), 1.0F, 0.5F * (root + knee));
            const BodyId shin = s.add(Shape::capsule(0.08F, 0.1F), 0.5F, knee + 0.3F * (root - at));
            s.join(joint_of(JointKind::kBall, trunk, thigh, root));
            JointDef def = joint_of(JointKind::kHinge, thigh, shin, knee);
            def.axis = Vec3::UnitZ();
            def.limited = true;
            def.lower = -1.0F;
            def.upper = 0.5F;
            def.motor = limb == 0;
            def.motor_max = 5.0F;
            s.join(def);
        }
    }
    std::vector<std::uint64_t> hashes;
    hashes.reserve(static_cast<std::size_t>(frames));
    for (int i = 0; i < frames; ++i) {
        const std::uint64_t before = allocation_count();
        s.scene.step(kFrame);
        if (count_allocations && i >= frames / 2) {
            EXPECT_EQ(allocation_count(), before) << "frame " << i;
        }
        core::StateHash hash;
        s.scene.hash(hash);
        hashes.push_back(hash.value());
    }
    EXPECT_TRUE(s.sums().finite);
    return hashes;
}

TEST(Determinism, OfJointsIsToTheBit) {
    EXPECT_EQ(run_joints(200, false), run_joints(200, false));
}

TEST(Step, WithJointsDoesNotAllocateAfterWarmUp) {
    run_joints(400, true);
}

/// A link of 1 kg, 0.5 m from its centre to a joint that carries F, swings about its centre. Its
/// frequency is w = sqrt(F r / I) = sqrt(3 F / (m r)) for a thin rod: at F = m g of 10 kg 24 rad/s,
/// of 10 t 767 rad/s. With w h <= 0.75 the first needs fewer substeps than the minimum, the other
/// 17, so 32.
TEST(SubstepPolicy, ResolvesTheSwingOfLinksThatHoldWhatIsHeavy) {
    for (const float end : {10.0F, 1.0e4F}) {
        JointScene s(kDown);
        const std::vector<BodyId> links = add_chain(s, 3, BodyId(), Vec3::Zero());
        const Vec3 tip(3.0F, 0, 0);
        const BodyId load = s.add(Shape::sphere(0.4F), end, tip);
        s.join(joint_of(JointKind::kBall, links.back(), load, tip));
        // Hung up, at rest: nothing but the load asks for more.
        Quat down(Eigen::AngleAxisf(-0.5F * std::numbers::pi_v<float>, Vec3::UnitZ()));
        for (const auto& [id, def] : s.bodies) {
            BodyState state = s.scene.state(id);
            state.position = down * state.position;
            state.orientation = down;
            s.scene.set_state(id, state);
        }
        std::uint32_t substeps = 0;
        for (int i = 0; i < 30; ++i) {
            substeps = s.scene.step(kFrame).substeps;
        }
        EXPECT_EQ(substeps, end > 100.0F ? 32U : 4U);
    }
}

/// Two rods between the same points, one a quarter longer: they pull against each other, the more
/// the stiffer they are, and no number of substeps changes that.
TEST(SubstepPolicy, IsNotSpentOnJointsThatContradictEachOther) {
    JointScene s;
    const BodyId a = s.add(kLink, 1.0F, Vec3(0, 0, 0));
    const BodyId b = s.add(kLink, 1.0F, Vec3(1, 0, 0));
    for (const float length : {1.0F, 1.25F}) {
        JointDef def = joint_of(JointKind::kDistance, a, b, Vec3(0.4F, 0, 0));
        def.anchor_b = Vec3(1.4F, 0.1F, 0);
        def.length_m = length;
        s.join(def);
    }
    for (int i = 0; i < 120; ++i) {
        EXPECT_LE(s.scene.step(kFrame).substeps, 8U) << i;
    }
}

}  // namespace
}  // namespace zoned::physics
