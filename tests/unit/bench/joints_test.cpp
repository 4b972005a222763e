#include "tests/bench/motion_sums.h"
#include "tests/bench/simulator.h"

#include <gtest/gtest.h>

namespace zoned::bench {
namespace {

/// A ball on a hinge along x, held by the world; no gravity.
scenario::Description hinged_ball() {
    scenario::Description d;
    d.gravity = Vec3d::Zero();
    scenario::Body post;
    post.mass = 0.0;
    scenario::Body ball;
    ball.solid = scenario::Solid::sphere(0.5);
    ball.pose.position = Vec3d(2.0, 0.0, 0.0);
    d.bodies = {post, ball};
    scenario::LinkedPair hinge;
    hinge.a = 0;
    hinge.b = 1;
    hinge.anchor = ball.pose.position;
    hinge.link = scenario::Link::kHinge;
    d.joints.push_back(hinge);
    return d;
}

std::vector<Motion> after_a_second(const scenario::Description& d) {
    std::vector<Motion> motions;
    for (const auto& engines : {zoned_engines(), bullet_engines()}) {
        const auto simulator = engines.front().build(d);
        for (int i = 0; i < 60; ++i) {
            simulator->step();
        }
        EXPECT_LT(joint_errors(d, *simulator).gap_m, 1e-3) << engines.front().peer;
        motions.push_back(simulator->motion(1));
    }
    return motions;
}

TEST(Engines, TurnTheSecondBodyOfAHingeByItsMotor) {
    scenario::Description d = hinged_ball();
    d.joints[0].motor_torque = 100.0;
    d.joints[0].motor_speed = 3.0;
    for (const Motion& m : after_a_second(d)) {
        EXPECT_NEAR(m.spin.x(), 3.0, 0.01);
    }
}

/// 0.1 kg m2 and 0.05 N m for a second: half a radian a second.
TEST(Engines, GiveAMotorNoMoreThanItsTorque) {
    scenario::Description d = hinged_ball();
    d.joints[0].motor_torque = 0.05;
    d.joints[0].motor_speed = 3.0;
    for (const Motion& m : after_a_second(d)) {
        EXPECT_NEAR(m.spin.x(), 0.5, 0.01);
    }
}

/// Turning on at 1 rad/s it would be at 1 rad; the angle is twice that of the quaternion's half.
TEST(Engines, StopAHingeAtItsLimits) {
    for (const double side : {-1.0, 1.0}) {
        scenario::Description d = hinged_ball();
        d.bodies[1].spin = Vec3d(side, 0.0, 0.0);
        d.joints[0].limited = true;
        d.joints[0].lower = -0.25;
        d.joints[0].upper = 0.5;
        double farthest = side > 0.0 ? 0.5 : -0.25;
        for (const auto& engines : {zoned_engines(), bullet_engines()}) {
            const auto simulator = engines.front().build(d);
            double angle = 0.0;
            for (int i = 0; i < 60; ++i) {
                simulator->step();
                const auto& q = simulator->motion(1).pose.orientation;
                const double now = 2.0 * std::atan2(q.x(), q.w());
                angle = side * now > side * angle ? now : angle;
            }
            EXPECT_NEAR(angle, farthest, 0.05) << engines.front().peer;
        }
    }
}

}  // namespace
}  // namespace zoned::bench
