// Joints in motion, against closed forms: pendulums, springs, limits, motors, sliders.
#include "tests/unit/physics/joint_scene.h"
#include "tests/unit/physics/physics_test.h"
#include "shared/core/rng.h"

#include <cfloat>
#include <cmath>
#include <numbers>

namespace zoned::physics {
namespace {

constexpr double kPi = std::numbers::pi;

/// Mean time between upward crossings of zero, s; the crossing within a step by interpolation.
template <class Value>
double period_of(JointScene& s, int steps, Value&& value) {
    double first = -1.0;
    double last = -1.0;
    int count = 0;
    double before = value();
    for (int i = 1; i <= steps; ++i) {
        s.scene.step(kFrame);
        const double now = value();
        if (before < 0.0 && now >= 0.0) {
            last = (i - now / (now - before)) * static_cast<double>(kFrame);
            first = first < 0.0 ? last : first;
            ++count;
        }
        before = now;
    }
    return count > 1 ? (last - first) / (count - 1) : 0.0;
}

TEST(Pendulum, OfSmallAngleSwingsWithItsClosedFormPeriodAndKeepsItsEnergy) {
    for (const JointKind kind : {JointKind::kBall, JointKind::kHinge}) {
        JointScene s(kDown);
        constexpr float kLength = 1.0F;
        constexpr float kAngle = 0.05F;
        const Vec3 start(kLength * std::sin(kAngle), -kLength * std::cos(kAngle), 0);
        const BodyId bob = s.add(Shape::sphere(0.1F), 2.0F, start);
        JointDef def = joint_of(kind, BodyId(), bob, Vec3::Zero());
        def.axis = Vec3::UnitZ();
        s.join(def);
        const double before = s.sums().energy;
        const double swing = 2.0 * 9.81 * kLength * (1.0 - std::cos(static_cast<double>(kAngle)));
        const double period = period_of(
            s, 1800, [&] { return static_cast<double>(s.scene.state(bob).position.x()); });
        // Compound: (L^2 + 2/5 r^2) / (g L); the angle lengthens it by angle^2 / 16 = 1.6e-4.
        const double exact = 2.0 * kPi * std::sqrt((1.0 + 0.4 * 0.01) / 9.81) *
                             (1.0 + static_cast<double>(kAngle * kAngle) / 16.0);
        // Second order in w h = 3.1 / 240: (w h)^2 / 24 = 7e-6, and 30 s hold 15 periods of
        // crossings known to about 1e-5 s.
        EXPECT_NEAR(period / exact, 1.0, 1e-4) << static_cast<int>(kind);
        EXPECT_NEAR(s.sums().energy, before, 0.005 * swing) << static_cast<int>(kind);
        EXPECT_LT(std::abs(s.scene.state(bob).position.z()), 1e-5F);
    }
}

TEST(Pendulum, DoubleOneKeepsItsEnergyWhileItTumbles) {
    JointScene s(kDown);
    const Shape rod = Shape::box(Vec3(0.5F, 0.05F, 0.05F));
    const BodyId upper = s.add(rod, 1.0F, Vec3(0.5F, 0, 0));
    const BodyId lower = s.add(rod, 1.0F, Vec3(1.5F, 0, 0));
    s.join(joint_of(JointKind::kBall, BodyId(), upper, Vec3::Zero()));
    const JointId elbow = s.join(joint_of(JointKind::kBall, upper, lower, Vec3(1, 0, 0)));
    const double before = s.sums().energy;
    // The drop over the swing: both middles fall by their distance from the hinge.
    const double scale = 9.81 * (0.5 + 1.5);
    for (int i = 0; i < 1200; ++i) {
        s.scene.step(kFrame);
        // The step is of second order where forces are smooth. A whip of the lower rod turns at up
        // to 15 rad/s: (w h)^2 = 0.004 at its 240 Hz or more.
        ASSERT_NEAR(s.sums().energy, before, 0.05 * scale) << i;
        ASSERT_LT(s.scene.joint_position(elbow), 1e-3F) << i;
    }
}

/// Two masses on a spring along x, set off at the given speed: amplitude and period.
struct FlappingPair {
    double period = 0.0;
    double decay = 0.0;  ///< ratio of successive maxima of the same side
};

FlappingPair oscillate(float hz, float damping, const Vec3& gravity) {
    JointScene s(gravity);
    const BodyId a = s.add(Shape::sphere(0.1F), 2.0F, Vec3(0, 0, 0));
    const BodyId b = s.add(Shape::sphere(0.1F), 3.0F, Vec3(2, 0, 0));
    JointDef def = joint_of(JointKind::kSpring, a, b, Vec3(0, 0, 0));
    def.anchor_b = Vec3(2, 0, 0);
    def.spring_hz = hz;
    def.spring_damping_ratio = damping;
    def.length_m = 1.8F;  // begins stretched
    const JointId spring = s.join(def);
    FlappingPair out;
    double highest = 0.0;
    double previous = 0.0;
    double sum = 0.0;
    int peaks = 0;
    out.period = period_of(s, 300, [&] {
        const double x = static_cast<double>(s.scene.joint_position(spring)) - 1.8;
        if (x > 0.0) {
            highest = std::max(highest, x);
        } else if (highest > 0.0) {
            if (previous > 0.0) {
                sum += std::log(highest / previous);
                ++peaks;
            }
            previous = highest;
            highest = 0.0;
        }
        return x;
    });
    out.decay = peaks > 0 ? std::exp(sum / peaks) : 0.0;
    return out;
}

TEST(Spring, OfTwoMassesSwingsAndFadesAsTheClosedFormSays) {
    for (const Vec3& gravity : {Vec3(0, 0, 0), kDown}) {
        for (const float damping : {0.0F, 0.02F, 0.1F}) {
            constexpr double kHz = 2.0;
            const FlappingPair o = oscillate(static_cast<float>(kHz), damping, gravity);
            const double z = static_cast<double>(damping);
            const double period = 1.0 / (kHz * std::sqrt(1.0 - z * z));
            const double decay = std::exp(-2.0 * kPi * z / std::sqrt(1.0 - z * z));
            // Implicit midpoint: (w h)^2 / 12 = 2.3e-4 with w h = 2 pi 2 / 240, and extrema are
            // read at frames, where the swing is off its top by up to 1 - cos(w / 120) = 0.5 %.
            EXPECT_NEAR(o.period / period, 1.0, 3e-4) << damping;
            EXPECT_NEAR(o.decay, decay, 0.001) << damping;
        }
    }
}

TEST(Spring, StaysStableWhereItIsFarStifferThanTheStep) {
    for (const float hz : {100.0F, 1000.0F}) {
        JointScene s(Vec3::Zero());
        const BodyId a = s.add(Shape::sphere(0.1F), 1.0F, Vec3(0, 0, 0));
        const BodyId b = s.add(Shape::sphere(0.1F), 1.0F, Vec3(1, 0, 0), Vec3(2, 0, 0));
        JointDef def = joint_of(JointKind::kSpring, a, b, Vec3(0, 0, 0));
        def.anchor_b = Vec3(1, 0, 0);
        def.spring_hz = hz;
        def.spring_damping_ratio = 0.0F;
        const JointId spring = s.join(def);
        const double before = s.sums().kinetic;
        for (int i = 0; i < 300; ++i) {
            s.scene.step(kFrame);
            // Energy is kept but for rounding. A length of 1 m is known to 6e-8 m, and the swing's
            // amplitude is v / w = 3e-4 m at 1000 Hz. So each of 2e4 substeps rounds the energy by
            // some 2e-4 at random sign: 3 %.
            ASSERT_LT(s.sums().kinetic, before * 1.1) << i;
            ASSERT_NEAR(s.scene.joint_position(spring), 1.0F, 0.02F) << i;
        }
        // 2e4 roundings of two speeds of 1 m/s at random sign: 1.5e-5 is one deviation.
        EXPECT_NEAR(s.sums().linear.x(), 2.0, 8e-5);
    }
}

TEST(DistanceJoint, InOneDimensionMovesBothAsTheirCentreOfMassDoes) {
    JointScene s(Vec3::Zero());
    const BodyId a = s.add(Shape::sphere(0.1F), 1.0F, Vec3(0, 0, 0), Vec3(5, 0, 0));
    const BodyId b = s.add(Shape::sphere(0.1F), 4.0F, Vec3(2, 0, 0));
    JointDef def = joint_of(JointKind::kDistance, a, b, Vec3(0, 0, 0));
    def.anchor_b = Vec3(2, 0, 0);
    const JointId rod = s.join(def);
    s.run(2.0F);
    EXPECT_NEAR(s.scene.joint_position(rod), 2.0F, 1e-5F);
    // A plastic shock along the rod, then both at 5 / 5 m/s.
    EXPECT_NEAR(s.scene.state(a).velocity.x(), 1.0F, 1e-5F);
    EXPECT_NEAR(s.scene.state(b).velocity.x(), 1.0F, 1e-5F);
    EXPECT_NEAR(s.scene.state(b).position.x(), 4.0F, 1e-4F);
}

TEST(DistanceJoint, OfAConicalPendulumCarriesWhatGravityAndTheTurnAskFor) {
    // A mass on a rod of 1 m at 45 degrees circles at w^2 = g / (L cos a); the rod pulls m g / cos.
    JointScene s(kDown);
    const float h = std::sqrt(0.5F);
    const float speed = std::sqrt(kGravity / h) * h;
    const BodyId bob = s.add(Shape::sphere(0.1F), 2.0F, Vec3(h, -h, 0), Vec3(0, 0, speed));
    JointDef def = joint_of(JointKind::kDistance, BodyId(), bob, Vec3::Zero());
    def.anchor_b = Vec3(h, -h, 0);
    const JointId rod = s.join(def);
    for (int i = 0; i < 600; ++i) {
        s.scene.step(kFrame);
        ASSERT_NEAR(s.scene.state(bob).position.y(), -h, 0.005F) << i;
        ASSERT_NEAR(s.scene.joint_position(rod), 1.0F, 2e-4F) << i;
    }
    EXPECT_NEAR(s.scene.joint_force(rod), 2.0F * kGravity / h, 0.01F * 2.0F * kGravity / h);
}

TEST(HingeLimit, StopsWhatSwingsIntoItAndHoldsItThere) {
    // A rod and, harder, a small heavy ball far from its hinge: its moment about the hinge is a
    // thousand times that about its middle.
    for (const bool ball : {false, true}) {
        JointScene s(kDown);
        const Shape shape = ball ? Shape::sphere(0.05F) : Shape::box(Vec3(0.5F, 0.05F, 0.05F));
        const Vec3 middle(ball ? 1.0F : 0.5F, 0, 0);
        const BodyId arm = s.add(shape, 2.0F, middle);
        JointDef def = joint_of(JointKind::kHinge, BodyId(), arm, Vec3::Zero());
        def.axis = Vec3::UnitZ();
        def.limited = true;
        def.lower = -0.5F;
        def.upper = 0.25F;
        const JointId hinge = s.join(def);
        float lowest = 0.0F;
        for (int i = 0; i < 300; ++i) {
            s.scene.step(kFrame);
            lowest = std::min(lowest, s.scene.joint_position(hinge));
        }
        // Stopped within a substep: at most the travel of one, 4 rad/s / 240, and in the end at
        // the limit.
        EXPECT_GT(lowest, -0.5F - 0.017F) << ball;
        EXPECT_NEAR(s.scene.joint_position(hinge), -0.5F, 0.005F) << ball;
        EXPECT_LT(s.scene.state(arm).angular_velocity.norm(), 0.02F) << ball;
        EXPECT_NEAR(s.scene.state(arm).position.norm(), middle.norm(), 1e-3F) << ball;
    }
}

TEST(HingeMotor, ReachesItsSpeedWithItsGreatestTorqueAndKeepsIt) {
    JointScene s(Vec3::Zero());
    // About its end: m l^2 / 3 and a little for its thickness.
    const Shape rod = Shape::box(Vec3(0.5F, 0.05F, 0.05F));
    const BodyId arm = s.add(rod, 3.0F, Vec3(0.5F, 0, 0));
    JointDef def = joint_of(JointKind::kHinge, BodyId(), arm, Vec3::Zero());
    def.axis = Vec3::UnitZ();
    def.motor = true;
    def.motor_speed = 6.0F;
    def.motor_max = 4.0F;
    s.join(def);
    const float moment = principal_inertia(rod, 3.0F).z() + 3.0F * 0.25F;
    s.run(0.5F);
    // Half a second at 4 N m: the arm has not got there yet.
    EXPECT_NEAR(s.scene.state(arm).angular_velocity.z(), 4.0F * 0.5F / moment, 0.01F);
    s.run(3.5F);
    EXPECT_NEAR(s.scene.state(arm).angular_velocity.z(), 6.0F, 0.01F);
}

TEST(SliderMotor, PushesWithItsGreatestForceAndHoldsAgainstGravity) {
    JointScene s(kDown);
    const BodyId lift = s.add(Shape::box(Vec3(1, 0.1F, 1)), 10.0F, Vec3(2, 0, 0));
    JointDef def = joint_of(JointKind::kSlider, BodyId(), lift, Vec3::Zero());
    def.axis = Vec3(0, 2, 0);
    def.motor = true;
    def.motor_speed = 1.5F;
    def.motor_max = 10.0F * (kGravity + 2.0F);  // 2 m/s2 upwards
    const JointId slider = s.join(def);
    s.run(0.5F);
    EXPECT_NEAR(s.scene.state(lift).velocity.y(), 1.0F, 0.01F);
    s.run(1.5F);
    EXPECT_NEAR(s.scene.state(lift).velocity.y(), 1.5F, 0.001F);
    s.scene.set_motor(slider, 0.0F, 500.0F);
    s.run(0.5F);
    const float held = s.scene.joint_position(slider);
    s.run(2.0F);
    EXPECT_NEAR(s.scene.joint_position(slider), held, 0.002F);
}

TEST(SliderLimit, StopsWhatSlidesIntoIt) {
    JointScene s(kDown);
    const BodyId lift = s.add(Shape::box(Vec3(1, 0.1F, 1)), 10.0F, Vec3(2, 0, 0));
    JointDef def = joint_of(JointKind::kSlider, BodyId(), lift, Vec3::Zero());
    def.limited = true;
    def.lower = -1.0F;
    def.upper = 1.0F;
    const JointId slider = s.join(def);
    s.run(3.0F);
    EXPECT_NEAR(s.scene.joint_position(slider), -1.0F, 0.002F);
    EXPECT_LT(s.scene.state(lift).velocity.norm(), 0.01F);
}

TEST(Slider, MovesAlongItsAxisOnlyWhateverPushesIt) {
    JointScene s(Vec3::Zero());
    const BodyId cart = s.add(Shape::box(Vec3(0.3F, 0.2F, 0.1F)), 2.0F, Vec3(1, 2, 3));
    JointDef def = joint_of(JointKind::kSlider, BodyId(), cart, Vec3(1, 2, 3));
    def.axis = Vec3(1, 1, 0);
    s.join(def);
    const Vec3 axis = def.axis.normalized();
    for (int i = 0; i < 240; ++i) {
        const Vec3 push(std::sin(0.3F * static_cast<float>(i)), 1.0F, -0.5F);
        s.scene.apply_impulse(cart, push, s.scene.state(cart).position + Vec3(0.2F, 0.3F, -0.1F));
        s.scene.step(kFrame);
        const BodyState state = s.scene.state(cart);
        const Vec3 away = state.position - Vec3(1, 2, 3);
        ASSERT_LT((away - away.dot(axis) * axis).norm(), 2e-4F) << i;
        ASSERT_LT(state.orientation.vec().norm(), 1e-4F) << i;
    }
    EXPECT_GT((s.scene.state(cart).position - Vec3(1, 2, 3)).norm(), 10.0F);
}

TEST(FixedJoint, BetweenTumblingBodiesConservesMomentum) {
    JointScene s(Vec3::Zero());
    const BodyId a = s.add(
        Shape::box(Vec3(0.5F, 0.3F, 0.2F)), 2.0F, Vec3(0, 0, 0), Vec3(1, 2, 0), Vec3(3, -2, 1));
    const BodyId b =
        s.add(Shape::capsule(0.2F, 0.4F), 1.0F, Vec3(1, 0.2F, 0), Vec3(-1, 0, 1), Vec3(-1, 4, 2));
    const JointId joint = s.join(joint_of(JointKind::kFixed, a, b, Vec3(0.6F, 0.1F, 0)));
    const auto before = s.sums();
    double energy = 0.0;
    for (int i = 0; i < 600; ++i) {
        s.scene.step(kFrame);
        ASSERT_LT(s.scene.joint_position(joint), 5e-4F) << i;
        if (i == 5) {
            energy = s.sums().kinetic;  // the shock of joining them is over
        }
    }
    const auto after = s.sums();
    // Impulses of a joint are equal and opposite; each rounds the momenta by an epsilon of their
    // size, 600 frames of a few substeps and 12 numbers at random sign.
    const double bound = 400.0 * static_cast<double>(FLT_EPSILON) * before.size;
    EXPECT_LT((after.linear - before.linear).norm(), bound);
    EXPECT_LT((after.angular - before.angular).norm(), 10 * bound);
    EXPECT_NEAR(after.kinetic / energy, 1.0, 0.02);
    EXPECT_LT(s.scene.state(a).orientation.angularDistance(s.scene.state(b).orientation), 1e-3F);
}

/// A sphere that spins on a ball joint at its centre: w falls by M / I a second, and stays at rest.
TEST(Friction, OfABallJointBrakesAsItsTorqueSays) {
    JointScene s;
    const BodyId ball = s.add(Shape::sphere(0.5F), 2.0F, Vec3::Zero(), Vec3::Zero(), {0, 3.0F, 0});
    JointDef def = joint_of(JointKind::kBall, BodyId(), ball, Vec3::Zero());
    def.motor = true;
    def.motor_max = 0.4F;  // I = 2/5 m r^2 = 0.2 kg m2: 2 rad/s2
    s.join(def);
    s.run(1.0F);
    EXPECT_NEAR(s.scene.state(ball).angular_velocity.y(), 1.0F, 1e-4F);
    s.run(1.0F);
    EXPECT_LT(s.scene.state(ball).angular_velocity.norm(), 1e-5F);
}

/// A net in free fall that is too wide for a matrix: its joints are solved side by side where they
/// share no body. Did two of them share one, the impulse of one would be lost.
TEST(Sweeps, OfAWideNetKeepItsMomentum) {
    constexpr int kSide = 20;
    constexpr float kSpacing = 0.4F;
    constexpr float kSpeed = 0.5F;
    JointScene s;
    core::Rng rng(17);
    const auto any = [&] {
        return kSpeed * (2.0F * rng.unit() - 1.0F);
    };
    std::vector<BodyId> bodies;
    for (int i = 0; i < kSide * kSide; ++i) {
        const Vec3 x(kSpacing * static_cast<float>(i % kSide),
                     0.0F,
                     kSpacing * static_cast<float>(i / kSide));
        bodies.push_back(s.add(Shape::sphere(0.1F), 1.0F, x, {any(), any(), any()}));
    }
    for (int i = 0; i < kSide * kSide; ++i) {
        for (const int other : {i % kSide + 1 < kSide ? i + 1 : -1, i + kSide}) {
            if (other >= 0 && other < kSide * kSide) {
                const BodyId a = bodies[static_cast<std::size_t>(i)];
                const BodyId b = bodies[static_cast<std::size_t>(other)];
                const Vec3 middle = 0.5F * (s.scene.state(a).position + s.scene.state(b).position);
                s.join(joint_of(JointKind::kBall, a, b, middle));
            }
        }
    }
    const Vec3d before = s.sums().linear;
    s.run(1.0F);
    const auto after = s.sums();
    EXPECT_TRUE(after.finite);
    // Each impulse rounds two velocities by half an epsilon of their size, at random sign: 60
    // frames of up to 16 substeps, 10 passes, 760 joints, 3 rows; five deviations.
    const double roundings = std::sqrt(2.0 * 60 * 16 * 10 * 760 * 3);
    const double bound = 5.0 * roundings * 0.5 * static_cast<double>(FLT_EPSILON * kSpeed);
    EXPECT_LT((after.linear - before).norm(), bound);
}

}  // namespace
}  // namespace zoned::physics
