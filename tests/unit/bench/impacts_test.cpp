#include "tests/scenario/exact_impacts.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::scenario {
namespace {

std::vector<FlyingBall> row(int count, double gap) {
    std::vector<FlyingBall> balls(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < balls.size(); ++i) {
        balls[i].position.x() = static_cast<double>(i) * (1.0 + gap);
    }
    balls.front().velocity.x() = 2.0;
    return balls;
}

TEST(ExactImpacts, HandAnElasticSpeedDownTheRow) {
    for (const double gap : {0.0, 0.01}) {
        const std::vector<FlyingBall> end = fly(row(5, gap), 1.0, 2.0);
        for (std::size_t i = 0; i < 5; ++i) {
            EXPECT_NEAR(end[i].velocity.x(), i == 4 ? 2.0 : 0.0, 1e-12);
        }
    }
}

/// Three balls, e = 1/2: the first impact gives 1/4 and 3/4 of the speed. The second gives 3/16 and
/// 9/16, slower than the first ball, which comes after: 1/4 and 3/16 become 13/64 and 15/64.
TEST(ExactImpacts, FollowAnInelasticRowByHand) {
    const std::vector<FlyingBall> end = fly(row(3, 0.01), 0.5, 2.0);
    EXPECT_NEAR(end[0].velocity.x(), 2.0 * 13.0 / 64.0, 1e-12);
    EXPECT_NEAR(end[1].velocity.x(), 2.0 * 15.0 / 64.0, 1e-12);
    EXPECT_NEAR(end[2].velocity.x(), 2.0 * 9.0 / 16.0, 1e-12);
}

/// Balls that stick share the momentum.
TEST(ExactImpacts, LetStickyBallsGoOnTogether) {
    for (const FlyingBall& ball : fly(row(8, 0.0), 0.0, 2.0)) {
        EXPECT_NEAR(ball.velocity.x(), 2.0 / 8.0, 1e-8);
    }
}

/// Off centre by half the distance of the centres: the struck ball goes off along their line, at
/// 30 degrees, with cos(30) of the speed (equal masses, e = 1).
TEST(ExactImpacts, DeflectABallThatIsStruckOffCentre) {
    std::vector<FlyingBall> balls(2);
    balls[0].velocity = Vec3d(1.0, 0.0, 0.0);
    balls[1].position = Vec3d(5.0, 0.5, 0.0);
    const std::vector<FlyingBall> end = fly(balls, 1.0, 10.0);
    EXPECT_NEAR(end[1].velocity.norm(), std::cos(M_PI / 6.0), 1e-12);
    EXPECT_NEAR(std::atan2(end[1].velocity.y(), end[1].velocity.x()), M_PI / 6.0, 1e-12);
    EXPECT_NEAR((end[0].velocity + end[1].velocity - balls[0].velocity).norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace zoned::scenario
