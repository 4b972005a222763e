// Rolling and spinning friction, against closed forms: balls that roll out, tops that run down.
#include "tests/unit/physics/joint_scene.h"
#include "tests/unit/physics/physics_test.h"

#include <cmath>

namespace zoned::physics {
namespace {

constexpr float kRollingRadius = 0.5F;
constexpr double kRollingPull = 9.81;

void add_flat_floor(JointScene& s, const Material& material = {}) {
    BodyDef floor;
    floor.kind = BodyKind::kStatic;
    floor.shape = Shape::plane();
    floor.material = material;
    s.add(floor);
}

/// A ball on the floor that rolls along x without slipping.
BodyDef rolling_ball(float speed, float rolling_m, float spinning_m = 0.0F) {
    BodyDef ball;
    ball.shape = Shape::sphere(kRollingRadius);
    ball.mass = 2.0F;
    ball.material.friction = 1.0F;
    ball.material.rolling_m = rolling_m;
    ball.material.spinning_m = spinning_m;
    ball.position = Vec3(0, kRollingRadius, 0);
    ball.velocity = Vec3(speed, 0, 0);
    ball.angular_velocity = Vec3(0, 0, -speed / kRollingRadius);
    return ball;
}

// The moment b N slows the turn, friction F at the ground carries it over to the way:
// m d = F and I d / r = b N - F r with I = 2/5 m r^2 make d = 5/7 g b / r.
double slowing(double rolling_m) {
    return 5.0 / 7.0 * kRollingPull * rolling_m / static_cast<double>(kRollingRadius);
}

TEST(RollingFriction, SlowsABallByFiveSeventhsOfGravityTimesItsShareOfTheRadius) {
    for (const float length : {0.002F, 0.01F, 0.05F}) {
        JointScene s(kDown);
        add_flat_floor(s);
        const BodyId ball = s.add(rolling_ball(3.0F, length));
        s.run(1.0F);
        const BodyState state = s.scene.state(ball);
        const double lost = 3.0 - static_cast<double>(state.velocity.x());
        // The ball sags by 0.1 mm under its load, which makes its radius that much shorter.
        const double exact = slowing(static_cast<double>(length));
        EXPECT_NEAR(lost, exact, 0.005 * exact + 2.5e-4) << length;
        EXPECT_NEAR(state.angular_velocity.z(), -state.velocity.x() / kRollingRadius, 2e-3F)
            << length;
    }
}

TEST(RollingFriction, StopsABallAfterTheWayThatItsEnergyAllowsAndLetsItSleep) {
    JointScene s(kDown, true);
    add_flat_floor(s);
    const BodyId ball = s.add(rolling_ball(1.0F, 0.02F));
    s.run(6.0F);
    const double way = 1.0 / (2.0 * slowing(0.02));
    EXPECT_NEAR(static_cast<double>(s.scene.state(ball).position.x()) / way, 1.0, 0.01);
    EXPECT_TRUE(s.scene.state(ball).asleep);
}

TEST(RollingFriction, IsAbsentByDefault) {
    JointScene s(kDown);
    add_flat_floor(s);
    const BodyId ball = s.add(rolling_ball(3.0F, 0.0F));
    s.run(5.0F);
    EXPECT_NEAR(s.scene.state(ball).velocity.x(), 3.0F, 1e-3F);
}

TEST(RollingFriction, OfThePairsLargerLengthCounts) {
    JointScene s(kDown);
    Material sand;
    sand.friction = 1.0F;
    sand.rolling_m = 0.03F;
    add_flat_floor(s, sand);
    const BodyId ball = s.add(rolling_ball(2.0F, 0.01F));
    s.run(1.0F);
    EXPECT_NEAR(s.scene.state(ball).velocity.x(), 2.0 - slowing(0.03), 0.005 * slowing(0.03));
}

/// A ball starts at rest on a slope whose tangent is this share of rolling_m / radius; m after 4 s.
float way_down(float share) {
    constexpr float kLength = 0.05F;
    const float slope = std::atan(share * kLength / kRollingRadius);
    JointScene s(9.81F * Vec3(std::sin(slope), -std::cos(slope), 0));
    add_flat_floor(s);
    const BodyId ball = s.add(rolling_ball(0.0F, kLength));
    s.run(4.0F);
    return s.scene.state(ball).position.x();
}

TEST(RollingFriction, HoldsABallOnASlopeUpToItsShareOfTheRadius) {
    EXPECT_LT(std::abs(way_down(0.9F)), 0.002F);
    // Beyond it rolls with what the slope has too much: 5/7 g cos(slope) (1.5 - 1) 0.1.
    const double slope = std::atan(1.5 * 0.1);
    const double exact = 0.5 * 16.0 * 5.0 / 7.0 * kRollingPull * std::cos(slope) * 0.05;
    EXPECT_NEAR(static_cast<double>(way_down(1.5F)) / exact, 1.0, 0.01);
}

TEST(SpinningFriction, SlowsATopByItsLengthTimesTheLoad) {
    JointScene s(kDown, true);
    add_flat_floor(s);
    BodyDef top = rolling_ball(0.0F, 0.0F, 0.004F);
    top.angular_velocity = Vec3(0, 1.5F, 0);
    const BodyId id = s.add(top);
    s.run(1.0F);
    // I w' = -s m g with I = 2/5 m r^2.
    const double rate = 0.004 * kRollingPull / (0.4 * 0.25);
    EXPECT_NEAR(
        1.5 - static_cast<double>(s.scene.state(id).angular_velocity.y()), rate, 0.005 * rate);
    s.run(5.0F);
    EXPECT_TRUE(s.scene.state(id).asleep);
}

TEST(SpinningFriction, GivesTheOtherBodyWhatItTakes) {
    JointScene s(kDown);
    add_flat_floor(s, {0.0F, 0.0F});
    BodyDef disc;
    disc.shape = Shape::box(Vec3(1.0F, 0.1F, 1.0F));
    disc.mass = 5.0F;
    disc.material.friction = 0.0F;  // it turns freely on the floor
    disc.position = Vec3(0, 0.1F, 0);
    const BodyId below = s.add(disc);
    BodyDef top = rolling_ball(0.0F, 0.0F, 0.02F);
    top.material.friction = 0.0F;
    top.position.y() = 0.2F + kRollingRadius;
    top.angular_velocity = Vec3(0, 4.0F, 0);
    const BodyId above = s.add(top);
    const double before = s.sums().angular.y();
    s.run(1.0F);
    EXPECT_NEAR(s.sums().angular.y() / before, 1.0, 1e-4);
    s.run(9.0F);
    EXPECT_NEAR(s.sums().angular.y() / before, 1.0, 1e-3);
    EXPECT_NEAR(
        s.scene.state(above).angular_velocity.y(), s.scene.state(below).angular_velocity.y(), 1e-3F)
        << "both turn as one in the end";
    EXPECT_GT(s.scene.state(below).angular_velocity.y(), 0.1F);
}

}  // namespace
}  // namespace zoned::physics
