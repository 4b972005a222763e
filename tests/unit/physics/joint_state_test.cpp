// The state that joints carry over: a machine that is made anew in another scene goes on.
#include "server/physics/joints/joint_state.h"

#include "tests/unit/physics/joint_scene.h"
#include "tests/unit/physics/physics_test.h"
#include "shared/core/rng.h"

#include <cmath>
#include <limits>

namespace zoned::physics {
namespace {

/// An arm of a hinge with a motor, a limited hinge, a ball, a slider and a rod: it swings in the
/// air from the world's origin.
struct Arm {
    JointScene s{kDown};
    std::vector<JointDef> defs;
    std::vector<JointId> joints;

    void build() {
        const Shape link = Shape::box({0.4F, 0.1F, 0.1F});
        std::vector<BodyId> links;
        for (int i = 0; i < 5; ++i) {
            links.push_back(s.add(
                link, 1.0F + static_cast<float>(i), Vec3(0.5F + static_cast<float>(i), 0, 0)));
        }
        const auto add = [&](JointKind kind, int b) -> JointDef& {
            const std::size_t i = static_cast<std::size_t>(b);
            defs.push_back(joint_of(kind,
                                    b == 0 ? BodyId() : links[i - 1],
                                    links[i],
                                    Vec3(static_cast<float>(b), 0, 0)));
            defs.back().axis = Vec3::UnitZ();
            return defs.back();
        };
        add(JointKind::kHinge, 0).motor = true;
        defs.back().motor_speed = 3.0F;
        defs.back().motor_max = 200.0F;
        add(JointKind::kHinge, 1).limited = true;
        defs.back().lower = -0.4F;
        defs.back().upper = 0.2F;
        add(JointKind::kBall, 2);
        add(JointKind::kSlider, 3).axis = Vec3::UnitX();
        defs.back().limited = true;
        defs.back().upper = 0.3F;
        add(JointKind::kDistance, 4).anchor_b = Vec3(4.1F, 0.2F, 0);
        for (const JointDef& def : defs) {
            joints.push_back(s.join(def));
        }
    }

    /// The bodies of another arm as they are now, held by the same joints.
    void take_over(const Arm& from) {
        for (const JointScene::Known& known : from.s.bodies) {
            const BodyState now = from.s.scene.state(known.id);
            BodyDef def = known.def;
            def.position = now.position;
            def.orientation = now.orientation;
            def.velocity = now.velocity;
            def.angular_velocity = now.angular_velocity;
            s.add(def);
        }
        for (std::size_t i = 0; i < from.defs.size(); ++i) {
            const auto made_at = [&](BodyId body) {
                Frame frame;
                for (const JointScene::Known& known : from.s.bodies) {
                    frame.position = known.id == body ? known.def.position : frame.position;
                }
                return frame;
            };
            const JointDef& def = from.defs[i];
            const auto made = s.scene.add_joint(def, made_at(def.a), made_at(def.b));
            ASSERT_TRUE(made.ok());
            joints.push_back(*made);
        }
    }

    void carry_over(const Arm& from) {
        for (std::size_t i = 0; i < joints.size(); ++i) {
            s.scene.set_joint_state(joints[i], from.s.scene.joint_state(from.joints[i]));
        }
        for (std::size_t i = 0; i < s.bodies.size(); ++i) {
            s.scene.set_history(s.bodies[i].id, from.s.scene.history(from.s.bodies[i].id));
        }
    }

    [[nodiscard]] std::uint64_t hash() const {
        core::StateHash hash;
        s.scene.hash(hash);
        s.scene.hash_joints(hash);
        return hash.value();
    }
};

TEST(JointState, LetsAMachineGoOnInAnotherSceneToTheBit) {
    Arm stays;
    stays.build();
    stays.s.run(0.7F);
    Arm moves;
    moves.take_over(stays);
    moves.carry_over(stays);
    Arm forgets;
    forgets.take_over(stays);
    for (int i = 0; i < 60; ++i) {
        stays.s.scene.step(kFrame);
        moves.s.scene.step(kFrame);
        forgets.s.scene.step(kFrame);
        ASSERT_EQ(stays.hash(), moves.hash()) << "step " << i;
    }
    EXPECT_NE(stays.hash(), forgets.hash()) << "it is needed";
}

TEST(JointState, IsInTheHash) {
    Arm one;
    one.build();
    Arm other;
    other.build();
    one.s.run(0.3F);
    other.s.run(0.3F);
    ASSERT_EQ(one.hash(), other.hash());
    JointState state = other.s.scene.joint_state(other.joints[2]);
    state.impulse[1] += 0.001F;
    other.s.scene.set_joint_state(other.joints[2], state);
    EXPECT_NE(one.hash(), other.hash());
}

/// A state that comes from another zone may be damaged. An infinite impulse makes the inverse mass
/// NaN, which is not above zero, as that of a body that nothing moves.
TEST(JointState, ThatIsNotFiniteStopsItsBodiesAndIsReported) {
    for (const float impulse : {std::numeric_limits<float>::infinity(), kNan}) {
        JointScene s(kDown);
        const BodyId a = s.add(Shape::sphere(0.2F), 1.0F, Vec3(0, 0, 0));
        const BodyId b = s.add(Shape::sphere(0.2F), 1.0F, Vec3(1, 0, 0));
        const JointId joint = s.join(joint_of(JointKind::kBall, a, b, Vec3(0.5F, 0, 0)));
        s.run(0.1F);
        JointState state = s.scene.joint_state(joint);
        state.impulse[0] = impulse;
        s.scene.set_joint_state(joint, state);
        EXPECT_EQ(s.scene.step(kFrame).quarantined, 2U);
        EXPECT_TRUE(s.sums().finite);
    }
}

/// Boxes in a row on rods, the last of which turns by more than a radian within a substep. The rows
/// of its rod say nothing about it by the end of the substep: a relax pass that trusted them made
/// 1e36 J of 1e6 in four of 2,000 such chains, these.
TEST(RelaxPass, MakesNoEnergyOfBoxesThatSpinFasterThanTheirRowsFollow) {
    for (const std::uint64_t seed : {134U, 349U, 594U, 1909U}) {
        core::Rng rng(11, seed);
        const auto any = [&](float size) {
            const float x = rng.range(-size, size);
            const float y = rng.range(-size, size);
            const float z = rng.range(-size, size);
            return Vec3(x, y, z);
        };
        const float spin = std::pow(10.0F, rng.range(1.0F, 3.7F));
        const float heaviest = std::pow(10.0F, rng.range(0.0F, 3.0F));
        const int count = 2 + static_cast<int>(rng.range(0.0F, 3.0F));
        JointScene s;
        for (int i = 0; i < count; ++i) {
            const Vec3 half = i % 2 != 0 ? Vec3(0.5F, 0.05F, 0.1F) : Vec3(0.3F, 0.3F, 0.1F);
            s.add(Shape::box(half),
                  i == 0 ? heaviest : 1.0F,
                  Vec3(static_cast<float>(i), 0, 0),
                  Vec3::Zero(),
                  i == count - 1 ? any(spin) : Vec3(Vec3::Zero()));
        }
        for (std::size_t i = 0; i + 1 < s.bodies.size(); ++i) {
            const auto x = static_cast<float>(i);
            JointDef rod = joint_of(
                JointKind::kDistance, s.bodies[i].id, s.bodies[i + 1].id, Vec3(0.5F + x, 0.1F, 0));
            rod.anchor_b = Vec3(0.8F + x, 0, 0.1F);
            s.join(rod);
        }
        const double before = s.sums().kinetic;
        for (int step = 0; step < 60; ++step) {
            ASSERT_EQ(s.scene.step(kFrame).quarantined, 0U) << seed << " step " << step;
        }
        EXPECT_LT(s.sums().kinetic, 1.01 * before) << seed;
    }
}

}  // namespace
}  // namespace zoned::physics
