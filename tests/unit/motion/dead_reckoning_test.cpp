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
        const KinematicState from = random_state(rng);
        for (const PredictorOrder order :
             {PredictorOrder::kStatic, PredictorOrder::kLinear, PredictorOrder::kQuadratic}) {
            const KinematicState half = predict(from, order, 0.5F);
            const KinematicState twice = predict(half, PredictorOrder::kQuadratic, 0.5F);
            const KinematicState once = predict(from, order, 1.0F);
            EXPECT_LT((twice.position - once.position).norm(), 1e-3F);  // 8 ulp at 1 km
            EXPECT_LT((twice.velocity - once.velocity).norm(), 2e-5F);
            EXPECT_LT(angle_between(twice.orientation, once.orientation), 4e-6F);
        }
    }
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
