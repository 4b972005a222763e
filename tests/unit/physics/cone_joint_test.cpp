// Cone and twist of ball joints: where they stop a limb, what they leave free, and ragdolls that
// lie on them.
#include "server/physics/joints/joint_rows.h"
#include "tests/unit/physics/joint_scene.h"
#include "tests/unit/physics/physics_test.h"

#include <cmath>
#include <numbers>

namespace zoned::physics {
namespace {

constexpr float kConeHalfTurn = std::numbers::pi_v<float>;

/// A rod that hangs from the world by its upper end.
struct HangingRod {
    JointScene scene;
    BodyId rod;
    JointDef def;

    HangingRod(const Vec3& gravity, float cone_rad, const Vec3& spin = Vec3::Zero())
        : scene(gravity) {
        const Vec3 middle(0, -0.5F, 0);
        rod =
            scene.add(Shape::box(Vec3(0.05F, 0.5F, 0.05F)), 2.0F, middle, spin.cross(middle), spin);
        def = joint_of(JointKind::kBall, BodyId(), rod, Vec3::Zero());
        def.axis = -Vec3::UnitY();
        def.cone_rad = cone_rad;
    }

    void join() { scene.join(def); }

    [[nodiscard]] Joint made() const {
        JointPose at;
        at.position = Vec3(0, -0.5F, 0);
        return make_joint(def, {}, at);
    }

    [[nodiscard]] JointPose pose() const {
        const BodyState state = scene.scene.state(rod);
        return {state.position, state.orientation.toRotationMatrix()};
    }

    [[nodiscard]] float swing() const { return swing_angle(made(), {}, pose()); }

    [[nodiscard]] float twist() const { return twist_angle(made(), {}, pose()); }

    [[nodiscard]] BodyState state() const { return scene.scene.state(rod); }
};

TEST(ConeLimit, StopsAPendulumAtItsAngleInAnyDirection) {
    for (int i = 0; i < 12; ++i) {
        const float azimuth = static_cast<float>(i) * kConeHalfTurn / 6.0F;
        HangingRod s(9.81F * Vec3(std::cos(azimuth), 0.0F, std::sin(azimuth)), 0.5F);
        s.join();
        float most = 0.0F;
        for (int step = 0; step < 180; ++step) {
            s.scene.scene.step(kFrame);
            most = std::max(most, s.swing());
        }
        // The limit holds to rounding at rest. When it is reached the rod turns at up to
        // sqrt(3 g sin(0.5) / L) = 3.8 rad/s, and leaves a straight line by (w h)^2 / 2 = 1.3e-4.
        EXPECT_NEAR(s.swing(), 0.5F, 1e-3F) << i;
        EXPECT_LT(most, 0.5F + 3e-3F) << i;
        EXPECT_LT(s.state().angular_velocity.norm(), 0.01F) << i;
    }
}

TEST(ConeLimit, LeavesSwingsWithinItAlone) {
    HangingRod coned(kDown, 1.0F, Vec3(0.0F, 0.0F, 1.5F));
    HangingRod bare(kDown, 0.0F, Vec3(0.0F, 0.0F, 1.5F));
    coned.join();
    bare.join();
    coned.scene.run(3.0F);
    bare.scene.run(3.0F);
    EXPECT_LT((coned.state().position - bare.state().position).norm(), 1e-3F);
}

TEST(ConeLimit, LetsARodCircleOnItWithoutFriction) {
    constexpr float kCone = 0.6F;
    const Vec3 middle = Quat(Eigen::AngleAxisf(kCone, Vec3::UnitZ())) * Vec3(-Vec3::UnitY());
    HangingRod s(Vec3::Zero(), kCone, 3.0F * middle);  // it turns about the middle as one
    s.def.cone_axis = middle;
    s.join();
    const double energy = s.scene.sums().energy;
    const double about = s.scene.sums().angular.dot(middle.cast<double>());
    s.scene.run(5.0F);
    EXPECT_NEAR(s.swing(), kCone, 3e-3F);
    // A limit is left as slowly as it was passed: of what a straight path leaves the round cone by,
    // the energy is lost, 0.5 % a second here, and never made.
    EXPECT_GT(s.scene.sums().energy / energy, 0.95);
    EXPECT_LT(s.scene.sums().energy / energy, 1.001);
    EXPECT_NEAR(s.scene.sums().angular.dot(middle.cast<double>()) / about, 1.0, 0.025);
}

TEST(TwistLimit, StopsARodThatTurnsAboutItsOwnAxis) {
    for (const float sign : {-1.0F, 1.0F}) {
        HangingRod s(kDown, 0.5F, Vec3(0, sign * 2.0F, 0));
        s.def.limited = true;
        s.def.lower = -0.7F;
        s.def.upper = 0.4F;
        s.join();
        float most = 0.0F;
        for (int step = 0; step < 120; ++step) {
            s.scene.scene.step(kFrame);
            most = std::max(most, std::abs(s.twist()));
        }
        // The axis points down: a positive spin about y is a negative twist.
        const float limit = sign > 0.0F ? -0.7F : 0.4F;
        EXPECT_NEAR(s.twist(), limit, 2e-3F);
        EXPECT_LT(most, std::abs(limit) + 2e-3F);
        EXPECT_NEAR(s.state().angular_velocity.y(), 0.0F, 1e-2F);
    }
}

TEST(TwistLimit, LeavesTurnsWithinItAlone) {
    HangingRod s(kDown, 0.5F, Vec3(0, 0.25F, 0));
    s.def.limited = true;
    s.def.lower = -0.7F;
    s.def.upper = 0.4F;
    s.join();
    s.scene.run(2.0F);
    EXPECT_NEAR(s.twist(), -0.5F, 1e-3F);
    EXPECT_NEAR(s.state().angular_velocity.y(), 0.25F, 1e-4F);
}

TEST(ConeLimit, OfALeaningAxisCountsFromTheConesMiddle) {
    HangingRod s(kDown, 0.3F);
    s.def.cone_axis = Quat(Eigen::AngleAxisf(1.0F, Vec3::UnitX())) * Vec3(-Vec3::UnitY());
    EXPECT_NEAR(s.swing(), 1.0F, 1e-5F);
    EXPECT_NEAR(s.twist(), 0.0F, 1e-5F) << "as placed it is not twisted";
    s.join();
    s.scene.run(4.0F);
    EXPECT_NEAR(s.swing(), 0.3F, 2e-3F) << "it is drawn into the cone and lies on its lower edge";
}

TEST(BallLimits, AreRefusedWhereTheyMakeNoSense) {
    JointDef def = joint_of(JointKind::kBall, BodyId(), BodyId(1), Vec3::Zero());
    EXPECT_EQ(why_unfit(def), "");
    def.limited = true;
    def.lower = -1.0F;
    def.upper = 1.0F;
    EXPECT_NE(why_unfit(def), "") << "a twist without a cone";
    def.cone_rad = 1.0F;
    EXPECT_EQ(why_unfit(def), "");
    def.cone_rad = 3.0F;
    EXPECT_NE(why_unfit(def), "") << "a twist in a cone that lets it point straight back";
    def.limited = false;
    EXPECT_EQ(why_unfit(def), "");
    for (const float cone : {-1.0F, 0.001F, 3.2F, std::numeric_limits<float>::quiet_NaN()}) {
        def.cone_rad = cone;
        EXPECT_NE(why_unfit(def), "") << cone;
    }
}

/// Eleven capsules whose ball joints have narrow cones and twists, so that every fall ends on them.
class ConedRagdoll {
  public:
    ConedRagdoll(JointScene& s, const Vec3& feet, const Quat& turn, const Vec3& spin)
        : scene_(s),
          feet_(feet),
          turn_(turn),
          spin_(spin) {
        const BodyId pelvis = part(0.12F, 0.05F, 10.0F, {0.0F, 0.98F, 0.0F});
        const BodyId chest = part(0.15F, 0.10F, 20.0F, {0.0F, 1.28F, 0.0F});
        const BodyId head = part(0.10F, 0.03F, 5.0F, {0.0F, 1.66F, 0.0F});
        ball(pelvis, chest, {0.0F, 1.10F, 0.0F}, Vec3::UnitY(), 0.4F, 0.3F);
        ball(chest, head, {0.0F, 1.52F, 0.0F}, Vec3::UnitY(), 0.5F, 0.6F);
        for (const float side : {-1.0F, 1.0F}) {
            const BodyId upper_arm = part(0.05F, 0.10F, 2.5F, {0.25F * side, 1.27F, 0.0F});
            const BodyId forearm = part(0.045F, 0.10F, 1.5F, {0.25F * side, 0.97F, 0.0F});
            const BodyId thigh = part(0.075F, 0.145F, 7.0F, {0.1F * side, 0.68F, 0.0F});
            const BodyId shin = part(0.06F, 0.16F, 4.0F, {0.1F * side, 0.24F, 0.0F});
            ball(chest, upper_arm, {0.2F * side, 1.42F, 0.0F}, -Vec3::UnitY(), 0.9F, 0.5F);
            ball(pelvis, thigh, {0.1F * side, 0.90F, 0.0F}, -Vec3::UnitY(), 0.7F, 0.3F);
            hinge(upper_arm, forearm, {0.25F * side, 1.12F, 0.0F}, -Vec3::UnitX());
            hinge(thigh, shin, {0.1F * side, 0.46F, 0.0F}, Vec3::UnitX());
        }
    }

  private:
    [[nodiscard]] Vec3 place(const Vec3& at) const {
        return feet_ + turn_ * (at - Vec3::UnitY()) + Vec3::UnitY();
    }

    BodyId part(float radius, float half, float mass, const Vec3& at) {
        BodyDef def;
        def.shape = Shape::capsule(radius, half);
        def.mass = mass;
        def.position = place(at);
        def.orientation = turn_;
        def.angular_velocity = spin_;
        def.velocity = spin_.cross(def.position - feet_ - Vec3::UnitY());
        return scene_.add(def);
    }

    void ball(BodyId a,
              BodyId b,
              const Vec3& at,
              const Vec3& axis,
              float cone_rad,
              float twist_rad) {
        JointDef def = joint_of(JointKind::kBall, a, b, place(at));
        def.axis = turn_ * axis;
        def.cone_rad = cone_rad;
        def.limited = true;
        def.lower = -twist_rad;
        def.upper = twist_rad;
        rub(def);
        scene_.join(def);
    }

    void hinge(BodyId a, BodyId b, const Vec3& at, const Vec3& axis) {
        JointDef def = joint_of(JointKind::kHinge, a, b, place(at));
        def.axis = turn_ * axis;
        def.limited = true;
        def.upper = 2.2F;
        rub(def);
        scene_.join(def);
    }

    /// Without friction a head that hangs on the edge of its cone would swing for ever.
    static void rub(JointDef& def) {
        def.motor = true;
        def.motor_max = 0.2F;  // N m
    }

    JointScene& scene_;
    Vec3 feet_;
    Quat turn_;
    Vec3 spin_;
};

TEST(BallLimits, LeaveRagdollsQuietThatFallOnThem) {
    // The fastest spin that the wire carries: 40 turns a second.
    constexpr float kMostSpin = 40.0F * 2.0F * kConeHalfTurn;
    for (int i = 0; i < 6; ++i) {
        JointScene s(kDown, true);
        BodyDef floor;
        floor.kind = BodyKind::kStatic;
        floor.shape = Shape::plane();
        s.add(floor);
        const auto share = static_cast<float>(i);
        const Quat turn(Eigen::AngleAxisf(0.9F * share, Vec3(0.3F, 0.2F, 1.0F).normalized()));
        const ConedRagdoll doll(s, Vec3(0, 2.0F, 0), turn, Vec3(share, 0.5F, -share));
        const double before = s.sums().energy;
        float fastest = 0.0F;
        for (int step = 0; step < 600; ++step) {
            s.scene.step(kFrame);
            for (const JointScene::Known& body : s.bodies) {
                fastest = std::max(fastest, s.scene.state(body.id).angular_velocity.norm());
            }
            ASSERT_LT(s.sums().energy, before + 1.0) << i << " step " << step;
        }
        EXPECT_LT(fastest, kMostSpin) << i;
        int awake = 0;
        for (const JointScene::Known& body : s.bodies) {
            awake += body.def.kind != BodyKind::kDynamic || s.scene.state(body.id).asleep ? 0 : 1;
        }
        EXPECT_EQ(awake, 0) << i;
    }
}

}  // namespace
}  // namespace zoned::physics
