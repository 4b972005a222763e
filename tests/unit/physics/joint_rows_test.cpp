// Rows of joints: every Jacobian against the numerical derivative of its error, and the effective
// masses that the solver sees against masses worked out by hand.
#include "server/physics/joints/joint_rows.h"

#include "server/physics/joints/joint_solver.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics {
namespace {

/// A rigid motion: pose at time 0 and constant velocity and spin, in doubles.
struct Moving {
    Vec3d position = Vec3d::Zero();
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
    Vec3d velocity = Vec3d::Zero();
    Vec3d spin = Vec3d::Zero();

    [[nodiscard]] JointPose at(double t) const {
        const double angle = spin.norm() * t;
        const Vec3d axis = spin.norm() > 0.0 ? spin.normalized() : Vec3d(Vec3d::UnitX());
        const Eigen::Quaterniond turned(Eigen::AngleAxisd(angle, axis) * orientation);
        return {(position + t * velocity).cast<float>(), turned.toRotationMatrix().cast<float>()};
    }
};

Vec3d any_vector(core::Rng& rng, double size) {
    const auto s = static_cast<float>(size);
    const float x = rng.range(-s, s);
    const float y = rng.range(-s, s);
    const float z = rng.range(-s, s);
    return Vec3(x, y, z).cast<double>();
}

Moving any_motion(core::Rng& rng) {
    Moving m;
    m.position = any_vector(rng, 2.0);
    const Vec3d turn = any_vector(rng, 3.0);
    m.orientation = Eigen::AngleAxisd(turn.norm(), turn.normalized());
    m.velocity = any_vector(rng, 1.0);
    m.spin = any_vector(rng, 1.0);
    return m;
}

/// C of a row at some time. Motors have no C of their own: they drive the joint's position.
double error_at(const Joint& joint, const Moving& a, const Moving& b, std::size_t row, double t) {
    JointRows rows;
    const JointPose at_a = a.at(t);
    const JointPose at_b = b.at(t);
    write_rows(joint, at_a, at_b, rows);
    if (rows.rows[row].kind == RowKind::kMotor) {
        return static_cast<double>(joint_position(joint, at_a, at_b));
    }
    return static_cast<double>(rows.rows[row].error);
}

/// The five-point stencil: its truncation is t^4 / 30 of the fifth derivative. Spins are at most
/// 1.7 rad/s in each body, arms a few metres, and anchors half a metre apart. So that derivative is
/// below 1e4, the truncation below 1e-4 for t = 0.02 s. Rounding of C (a few metres, some ten
/// operations) adds 10 x 3 m x 6e-8 x 1.5 / 0.02 s = 1.4e-4.
double numerical_rate(const Joint& joint, const Moving& a, const Moving& b, std::size_t row) {
    constexpr double t = 0.02;
    const auto at = [&](double s) {
        return error_at(joint, a, b, row, s);
    };
    return (8.0 * (at(t) - at(-t)) - (at(2 * t) - at(-2 * t))) / (12.0 * t);
}

constexpr double kRateTolerance = 5.0e-4;

JointDef any_joint(core::Rng& rng, JointKind kind, const Moving& a) {
    JointDef def;
    def.kind = kind;
    def.anchor = (a.position + any_vector(rng, 1.0)).cast<float>();
    def.anchor_b = def.anchor + (Vec3d(1.5, 0.0, 0.0) + any_vector(rng, 0.5)).cast<float>();
    def.axis = any_vector(rng, 1.0).cast<float>();
    const bool has_axis = kind == JointKind::kHinge || kind == JointKind::kSlider;
    def.limited = has_axis || kind == JointKind::kBall;
    def.lower = -0.3F;
    def.upper = 0.2F;
    def.motor = has_axis;
    if (kind == JointKind::kBall) {
        // Well out of the cone's middle and well short of its back, where directions are sharp.
        const Vec3 axis = def.axis.normalized();
        const Vec3 about = axis.cross(any_vector(rng, 1.0).cast<float>()).normalized();
        def.cone_axis = Eigen::AngleAxisf(rng.range(0.9F, 1.7F), about) * axis;
        def.cone_rad = 1.2F;
    }
    return def;
}

/// Moves and turns b away from the joint's target.
void violate(core::Rng& rng, double metres, double radians, Moving& b) {
    b.position += any_vector(rng, metres);
    const Vec3d turn = any_vector(rng, radians);
    b.orientation = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * b.orientation;
}

void check_rates(JointKind kind, double metres, double radians) {
    core::Rng rng(7, static_cast<std::uint64_t>(kind));
    for (int i = 0; i < 200; ++i) {
        const Moving a = any_motion(rng);
        Moving b = any_motion(rng);
        const Joint joint = make_joint(any_joint(rng, kind, a), a.at(0), b.at(0));
        violate(rng, metres, radians, b);
        JointRows rows;
        write_rows(joint, a.at(0), b.at(0), rows);
        ASSERT_GE(rows.count, hard_rows(kind));
        for (std::size_t r = 0; r < rows.count; ++r) {
            const JointRow& row = rows.rows[r];
            const double rate = row.linear.cast<double>().dot(b.velocity - a.velocity) +
                                row.angular_a.cast<double>().dot(a.spin) +
                                row.angular_b.cast<double>().dot(b.spin);
            ASSERT_NEAR(rate, numerical_rate(joint, a, b, r), kRateTolerance)
                << "joint " << static_cast<int>(kind) << " row " << r << " case " << i;
            ASSERT_EQ(row.kind == RowKind::kHard, r < hard_rows(kind));
        }
    }
}

constexpr std::array kAllKinds{JointKind::kBall,
                               JointKind::kHinge,
                               JointKind::kSlider,
                               JointKind::kFixed,
                               JointKind::kDistance,
                               JointKind::kSpring};

TEST(JointRows, AreTheDerivativesOfTheirErrorsWhereTheJointHolds) {
    for (const JointKind kind : kAllKinds) {
        check_rates(kind, 0.0, 0.0);
    }
}

TEST(JointRows, AreTheDerivativesOfTheirErrorsWhereTheJointIsViolated) {
    // A hinge that is turned out of its axis by half a radian, a ball joint that gapes by 0.3 m.
    for (const JointKind kind : kAllKinds) {
        check_rates(kind, 0.3, 0.3);
    }
}

TEST(JointRows, HaveNoErrorWhereTheJointWasMade) {
    core::Rng rng(3);
    for (const JointKind kind : kAllKinds) {
        const Moving a = any_motion(rng);
        const Moving b = any_motion(rng);
        const Joint joint = make_joint(any_joint(rng, kind, a), a.at(0), b.at(0));
        JointRows rows;
        write_rows(joint, a.at(0), b.at(0), rows);
        for (std::size_t r = 0; r < hard_rows(kind); ++r) {
            // Some ten roundings of coordinates of a few metres.
            EXPECT_NEAR(rows.rows[r].error, 0.0F, 5e-6F) << static_cast<int>(kind) << " " << r;
        }
    }
}

TEST(JointRows, LimitsTellHowFarTheJointIsFromEachEnd) {
    for (const JointKind kind : {JointKind::kHinge, JointKind::kSlider}) {
        JointDef def;
        def.kind = kind;
        def.axis = Vec3(0, 0, 3);
        def.limited = true;
        def.lower = -0.25F;
        def.upper = 0.5F;
        const Joint joint = make_joint(def, JointPose(), JointPose());
        JointPose b;
        if (kind == JointKind::kHinge) {
            b.rotation = Eigen::AngleAxisf(0.125F, Vec3::UnitZ()).toRotationMatrix();
        } else {
            b.position = Vec3(0, 0, 0.125F);
        }
        EXPECT_NEAR(joint_position(joint, JointPose(), b), 0.125F, 1e-6F);
        JointRows rows;
        write_rows(joint, JointPose(), b, rows);
        ASSERT_EQ(rows.count, hard_rows(kind) + 2);
        EXPECT_EQ(rows.rows[hard_rows(kind)].kind, RowKind::kLimit);
        EXPECT_NEAR(rows.rows[hard_rows(kind)].error, 0.375F, 1e-6F);
        EXPECT_NEAR(rows.rows[hard_rows(kind) + 1].error, 0.375F, 1e-6F);
    }
}

/// Bodies and one joint, solved once: which impulse stops a given motion?
class OneJoint {
  public:
    std::uint32_t add(const Shape& shape, float mass, const Vec3& x, const Vec3& v, const Vec3& w) {
        BodyDef def;
        def.shape = shape;
        def.mass = mass;
        def.position = x;
        def.velocity = v;
        def.angular_velocity = w;
        const std::uint32_t row = bodies_.create(def);
        bodies_.mark_awake(row);
        return row;
    }

    /// The impulses of all rows after one unbiased solve.
    std::array<float, 9> impulses(const JointDef& def, std::uint32_t a, std::uint32_t b) {
        const auto pose = [&](std::uint32_t row) {
            return row == kNoIndex ? JointPose()
                                   : JointPose{bodies_.position[row], bodies_.rotation[row]};
        };
        JointTable table;
        table.add(bodies_, make_joint(def, pose(a), pose(b)), a, b);
        const std::uint32_t index = 0;
        SolverBodies moving;
        moving.begin(Vec3::Zero(), kStep, kStep);
        JointSolver solver;
        solver.prepare(bodies_, table, {&index, 1}, moving, kStep, 0.0F);
        solver.update(table, moving);
        solver.warm_start(moving);
        solver.solve(moving);
        solver.store(table, moving);
        return table[0].impulse;
    }

    static constexpr float kStep = 1.0F / 240.0F;

  private:
    Bodies bodies_;
};

/// A few roundings.
constexpr float kMassTolerance = 2e-6F;
constexpr float kMotorGive = 1.0e-5F;  ///< as JointSolver has it

TEST(EffectiveMass, OfTwoSpheresAtADistanceIsTheReducedMass) {
    OneJoint one;
    const auto ball = Shape::sphere(0.1F);
    const auto a = one.add(ball, 2.0F, Vec3(0, 0, 0), Vec3(0, 3, 0), Vec3(4, 5, 6));
    const auto b = one.add(ball, 3.0F, Vec3(2, 0, 0), Vec3(1, 0, 7), Vec3(1, 2, 3));
    JointDef def;
    def.kind = JointKind::kDistance;
    def.anchor = Vec3(0, 0, 0);
    def.anchor_b = Vec3(2, 0, 0);
    // Anchored at the centres: spins do not matter, the relative speed along the line is 1 m/s.
    EXPECT_NEAR(one.impulses(def, a, b)[0], -(2.0F * 3.0F / 5.0F) * 1.0F, 1.2F * kMassTolerance);
}

TEST(EffectiveMass, AtTheEndOfAnArmFallsByTheTurning) {
    OneJoint one;
    // A sphere of 2 kg held at its surface from the side: 1 / (1 / m + r^2 / (2/5 m r^2)).
    const auto b = one.add(Shape::sphere(0.5F), 2.0F, Vec3::Zero(), Vec3(0, 1, 0), Vec3::Zero());
    JointDef def;
    def.kind = JointKind::kDistance;
    def.anchor = Vec3(0.5F, 3, 0);
    def.anchor_b = Vec3(0.5F, 0, 0);
    // It rises towards the anchor: the push is down on b, away from the anchor.
    EXPECT_NEAR(one.impulses(def, kNoIndex, b)[0], 2.0F / 3.5F, kMassTolerance);
}

TEST(EffectiveMass, OfABallJointAtTheEndOfARodIsAQuarterAcrossAndTheMassAlong) {
    // A thin rod: I / m = l^2 / 12, so that across its end 1 / (1 / m + 3 / m).
    OneJoint one;
    const Shape rod = Shape::box(Vec3(0.5F, 0.001F, 0.001F));
    const auto b = one.add(rod, 4.0F, Vec3(0.5F, 0, 0), Vec3(1, 1, 0), Vec3::Zero());
    JointDef def;
    def.kind = JointKind::kBall;
    const auto impulse = one.impulses(def, kNoIndex, b);
    EXPECT_NEAR(impulse[0], -4.0F, 4 * kMassTolerance);
    // The rod's own thickness enters by (0.001 / 0.5)^2 = 4e-6 of its moment.
    EXPECT_NEAR(impulse[1], -1.0F, 5e-6F);
}

TEST(EffectiveMass, OfAMotorOnARodIsItsMomentAboutTheHinge) {
    // I + m r^2 = m l^2 / 3 about the end of a rod, not m l^2 / 12 about its middle.
    OneJoint one;
    const Shape rod = Shape::box(Vec3(0.5F, 0.001F, 0.001F));
    const auto b = one.add(rod, 3.0F, Vec3(0.5F, 0, 0), Vec3::Zero(), Vec3::Zero());
    JointDef def;
    def.kind = JointKind::kHinge;
    def.axis = Vec3::UnitZ();
    def.motor = true;
    def.motor_speed = 2.0F;
    def.motor_max = 1.0e6F;
    const auto impulse = one.impulses(def, kNoIndex, b);
    // The motor gives way by kMotorGive of what the free rod would, which is four times as much.
    const float given = 1.0F / (1.0F + 4.0F * kMotorGive);
    EXPECT_NEAR(impulse[5], 2.0F * 3.0F / 3.0F * given, 5e-5F);
    // The hinge carries the force that turns the rod's middle: m r w.
    EXPECT_NEAR(impulse[1], 3.0F * 0.5F * 2.0F * given, 5e-5F);
}

TEST(EffectiveMass, OfASliderIsTheMassAlongItsAxisAndNothingMovesAcross) {
    OneJoint one;
    const auto b = one.add(Shape::box(Vec3(0.5F, 0.25F, 0.1F)),
                           3.0F,
                           Vec3(0.3F, 0.2F, 0),
                           Vec3(0, 2, 1),
                           Vec3::Zero());
    JointDef def;
    def.kind = JointKind::kSlider;
    def.anchor = Vec3(0.3F, 0.2F, 0);
    def.axis = Vec3::UnitX();
    def.motor = true;
    def.motor_speed = 1.5F;
    def.motor_max = 1.0e6F;
    const auto impulse = one.impulses(def, kNoIndex, b);
    EXPECT_NEAR(impulse[5], 3.0F * 1.5F / (1.0F + kMotorGive), 10 * kMassTolerance);
    EXPECT_NEAR(std::hypot(impulse[3], impulse[4]), 3.0F * std::sqrt(5.0F), 20 * kMassTolerance);
}

TEST(EffectiveMass, MotorStopsAtItsGreatestForce) {
    OneJoint one;
    const auto b = one.add(Shape::sphere(0.5F), 1.0F, Vec3::Zero(), Vec3::Zero(), Vec3::Zero());
    JointDef def;
    def.kind = JointKind::kSlider;
    def.axis = Vec3::UnitX();
    def.motor = true;
    def.motor_speed = 100.0F;
    def.motor_max = 12.0F;
    EXPECT_FLOAT_EQ(one.impulses(def, kNoIndex, b)[5], 12.0F * OneJoint::kStep);
}

}  // namespace
}  // namespace zoned::physics
