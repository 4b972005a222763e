#include "shared/motion/dead_reckoning.h"

#include "tests/unit/motion/random_vector.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace zoned::motion {
namespace {

Quat random_orientation(core::Rng& rng) {
    // A point of the unit 4-sphere: reject points outside the ball, so that the test is uniform.
    for (;;) {
        const Eigen::Vector4f v(
            rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1));
        if (v.norm() > 0.1F && v.norm() <= 1.0F) {
            return Quat(v.normalized());
        }
    }
}

KinematicState random_state(core::Rng& rng) {
    KinematicState state;
    state.position = random_vector(rng, 1000.0F);
    state.orientation = random_orientation(rng);
    state.velocity = random_vector(rng, 30.0F);
    state.acceleration = random_vector(rng, 20.0F);
    state.angular_velocity = random_vector(rng, 3.0F);
    return state;
}

// A few float roundings, each of relative size 2^-24 = 6e-8, on values of the size of the terms.
constexpr double kRelative = 1e-6;

TEST(DeadReckoning, PositionsFollowTheClosedForm) {
    core::Rng rng(1);
    for (int i = 0; i < 1000; ++i) {
        const KinematicState from = random_state(rng);
        const float elapsed = rng.range(0.0F, 2.0F);
        const double t = elapsed;
        const Vec3d p = from.position.cast<double>();
        const Vec3d v = from.velocity.cast<double>();
        const Vec3d a = from.acceleration.cast<double>();
        const double size = p.norm() + v.norm() * t + a.norm() * t * t;

        EXPECT_EQ(predict_position(from, PredictorOrder::kStatic, elapsed), from.position);
        EXPECT_LT(
            (predict_position(from, PredictorOrder::kLinear, elapsed).cast<double>() - (p + v * t))
                .norm(),
            kRelative * size);
        EXPECT_LT((predict_position(from, PredictorOrder::kQuadratic, elapsed).cast<double>() -
                   (p + v * t + 0.5 * a * t * t))
                      .norm(),
                  kRelative * size);
    }
}

TEST(DeadReckoning, OrientationTurnsByTheRateAboutTheWorldAxis) {
    core::Rng rng(2);
    for (int i = 0; i < 1000; ++i) {
        const KinematicState from = random_state(rng);
        const float elapsed = rng.range(0.0F, 2.0F);
        const Vec3d w = from.angular_velocity.cast<double>();
        const double angle = w.norm() * elapsed;
        const Eigen::Quaterniond expected =
            Eigen::AngleAxisd(angle, w.normalized()) * from.orientation.cast<double>();
        const Quat got = predict_orientation(from, PredictorOrder::kQuadratic, elapsed);
        // The half angle is rounded before its sine is taken: the error grows with it.
        const double allowed = kRelative * (1.0 + 0.5 * angle);
        EXPECT_LT((got.coeffs().cast<double>() - expected.coeffs()).norm(), allowed);
        EXPECT_EQ(predict_orientation(from, PredictorOrder::kLinear, elapsed).coeffs(),
                  got.coeffs());
        EXPECT_EQ(predict_orientation(from, PredictorOrder::kStatic, elapsed).coeffs(),
                  from.orientation.coeffs());
    }
}

TEST(DeadReckoning, AQuarterTurnAboutUpTakesForwardToTheRightHandedSide) {
    KinematicState from;
    from.angular_velocity = Vec3(0.0F, 0.5F * std::numbers::pi_v<float>, 0.0F);
    const Quat q = predict_orientation(from, PredictorOrder::kLinear, 1.0F);
    EXPECT_LT((q * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-6F);
}

TEST(DeadReckoning, ThePredictedStateDescribesItsOwnFurtherMotion) {
    core::Rng rng(3);
    for (int i = 0; i < 300; ++i) {
        KinematicState from = random_state(rng);
        from.position = random_vector(rng, 20.0F);
        from.turn = random_vector(rng, 4.0F);
        from.acceleration.y() = -9.81F;
        from.floor = from.position.y() - rng.range(0.0F, 8.0F);
        for (int kind = 0; kind < kPredictorOrders; ++kind) {
            const auto order = static_cast<PredictorOrder>(kind);
            const KinematicState half = predict(from, order, 0.5F);
            // An entity at rest is predicted to stay by all orders below falling.
            const bool moves = !half.velocity.isZero();
            const KinematicState twice =
                predict(half, moves ? order : PredictorOrder::kQuadratic, 0.5F);
            const KinematicState once = predict(from, order, 1.0F);
            // Some 10 roundings at 50 m. When something lands depends on rounding divided by how
            // fast it does: 4e-6 m / 0.1 m/s, at 5 rad/s.
            const bool falls = order == PredictorOrder::kBallistic;
            EXPECT_LT((twice.position - once.position).norm(), 1e-4F);
            EXPECT_LT((twice.velocity - once.velocity).norm(), 1e-4F);
            EXPECT_LT(angle_between(twice.orientation, once.orientation), falls ? 2e-4F : 1e-5F);
        }
    }
}

// Around a centre that drifts with u, on a radius r, turning at w about an axis n, with any drift
// along n as well (a helix): p(t) = c + u t + R(w t) r.
TEST(DeadReckoning, TurningIsExactOnCirclesAndHelicesAboutDriftingCentres) {
    core::Rng rng(8);
    for (int i = 0; i < 2000; ++i) {
        const Vec3d n = random_vector(rng, 1.0F).cast<double>().normalized();
        const double w = static_cast<double>(rng.range(0.0F, 6.0F));
        const Vec3d r = n.cross(random_vector(rng, 1.0F).cast<double>()).normalized() * 5.0;
        const Vec3d u = random_vector(rng, 10.0F).cast<double>();
        const double t = static_cast<double>(rng.range(0.0F, 3.0F));
        KinematicState from;
        from.position = r.cast<float>();
        from.velocity = (u + w * n.cross(r)).cast<float>();
        from.acceleration = (-w * w * r).cast<float>();
        from.turn = (w * n).cast<float>();
        const Eigen::AngleAxisd turn(w * t, n);
        // Roundings of the inputs, relative 2^-24: of a (180 m/s2 at most) over t^2 / 2, of v (40
        // m/s) over t, of w (6 rad/s) as |a| dw t^3 / 6, and some of the result.
        const double allowed = 1e-6 * (1.0 + 5.0 * w * w * t * t * (1.0 + w * t) + 40.0 * t);
        const KinematicState to = predict(from, PredictorOrder::kTurning, static_cast<float>(t));
        EXPECT_LT((to.position.cast<double>() - (turn * r + u * t)).norm(), allowed);
        EXPECT_LT((to.velocity.cast<double>() - (u + w * n.cross(turn * r))).norm(),
                  allowed * (1.0 + w) + 1e-5);
    }
}

TEST(DeadReckoning, TurningWithoutATurnIsOrderTwo) {
    core::Rng rng(9);
    for (int i = 0; i < 300; ++i) {
        KinematicState from = random_state(rng);
        const float t = rng.range(0.0F, 2.0F);
        const Vec3 expected = predict_position(from, PredictorOrder::kQuadratic, t);
        EXPECT_LT((predict_position(from, PredictorOrder::kTurning, t) - expected).norm(), 1e-3F);
        from.turn = random_vector(rng, 1e-6F);
        EXPECT_LT((predict_position(from, PredictorOrder::kTurning, t) - expected).norm(), 1e-3F);
    }
}

TEST(DeadReckoning, WhatFallsRestsWhereItsFloorIs) {
    core::Rng rng(10);
    for (int i = 0; i < 1000; ++i) {
        KinematicState from = random_state(rng);
        from.position = random_vector(rng, 20.0F);
        from.acceleration = Vec3(0.0F, -9.81F, 0.0F);
        from.floor = from.position.y() - rng.range(0.0F, 15.0F);
        const float landing = landing_time(from);
        ASSERT_TRUE(std::isfinite(landing));
        // The root of the parabola, by substitution: rounding of terms up to 15 + 30 * 7 m.
        const KinematicState there = predict(from, PredictorOrder::kBallistic, landing);
        EXPECT_NEAR(there.position.y(), from.floor, 3e-4F);
        const KinematicState later = predict(from, PredictorOrder::kBallistic, landing + 5.0F);
        EXPECT_EQ(later.position, there.position);
        EXPECT_EQ(later.velocity, Vec3(Vec3::Zero()));
        EXPECT_EQ(later.angular_velocity, Vec3(Vec3::Zero()));
        // Until then it is order 2, and never under the floor.
        const float before = landing * rng.range(0.0F, 0.999F);
        EXPECT_EQ(predict_position(from, PredictorOrder::kBallistic, before),
                  predict_position(from, PredictorOrder::kQuadratic, before));
        EXPECT_GE(predict_position(from, PredictorOrder::kBallistic, before).y(),
                  from.floor - 1e-4F);
    }
}

TEST(DeadReckoning, WhatIsOnTheFloorStaysAndWhatHasNoneFallsOn) {
    KinematicState from;
    from.acceleration = Vec3(0.0F, -9.81F, 0.0F);
    from.velocity = Vec3(1.0F, -2.0F, 0.0F);
    EXPECT_TRUE(std::isinf(landing_time(from)));
    EXPECT_EQ(predict_position(from, PredictorOrder::kBallistic, 2.0F),
              predict_position(from, PredictorOrder::kQuadratic, 2.0F));
    from.floor = 0.0F;
    EXPECT_EQ(landing_time(from), 0.0F);
    EXPECT_EQ(predict_position(from, PredictorOrder::kBallistic, 2.0F), from.position);
    // Rising from the floor it comes back after 2 v / g.
    from.velocity.y() = 9.81F;
    EXPECT_NEAR(landing_time(from), 2.0F, 1e-6F);
}

TEST(DeadReckoning, NoTimeChangesNothing) {
    core::Rng rng(4);
    const KinematicState from = random_state(rng);
    const KinematicState to = predict(from, PredictorOrder::kQuadratic, 0.0F);
    EXPECT_EQ(to.position, from.position);
    EXPECT_EQ(to.velocity, from.velocity);
    EXPECT_LT(angle_between(to.orientation, from.orientation), 1e-6F);
}

TEST(AngleBetween, MeasuresAnglesFromMicroradiansToHalfATurn) {
    core::Rng rng(5);
    for (const double angle : {1e-6, 1e-5, 1e-4, 1e-3, 0.1, 1.0, 2.0, 3.0, 3.14159}) {
        for (int i = 0; i < 100; ++i) {
            const Quat a = random_orientation(rng);
            const Vec3d axis = random_vector(rng, 1.0F).cast<double>().normalized();
            const Quat b = (Eigen::AngleAxisd(angle, axis) * a.cast<double>()).cast<float>();
            // Rounding a and b to float alone moves each by up to sqrt(4) 2^-25 = 6e-8 in
            // quaternion space, which is twice that as an angle.
            EXPECT_NEAR(angle_between(a, b), angle, 6e-7 + 1e-6 * angle);
            EXPECT_NEAR(
                angle_between(a, Quat(Eigen::Vector4f(-b.coeffs()))), angle, 6e-7 + 1e-6 * angle);
        }
    }
}

TEST(AngleBetween, IsExactlyZeroForEqualOrientations) {
    core::Rng rng(6);
    for (int i = 0; i < 100; ++i) {
        const Quat a = random_orientation(rng);
        EXPECT_EQ(angle_between(a, a), 0.0F);
        EXPECT_EQ(angle_between(a, Quat(Eigen::Vector4f(-a.coeffs()))), 0.0F);
    }
}

}  // namespace
}  // namespace zoned::motion
