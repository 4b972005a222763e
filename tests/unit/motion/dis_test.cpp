#include "shared/motion/dis.h"

#include "shared/core/rng.h"
#include "shared/motion/turn_integrals.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::motion {
namespace {

constexpr double kTolerance = 1e-9;  // what the algorithms promise, m and of quaternions

Vec3d any_vector(core::Rng& rng, float limit) {
    return {rng.range(-limit, limit), rng.range(-limit, limit), rng.range(-limit, limit)};
}

DisState any_state(core::Rng& rng, float spin) {
    DisState s;
    s.position = any_vector(rng, 100.0F);
    s.velocity = any_vector(rng, 20.0F);
    s.acceleration = any_vector(rng, 10.0F);
    s.angular_velocity = any_vector(rng, spin);
    s.orientation =
        Eigen::Quaterniond(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1), rng.range(0.1F, 1))
            .normalized();
    return s;
}

/// Carries the equations of motion of an algorithm on by Gauss-Legendre collocation of sixth order
/// in small steps: nothing of the closed forms is in it. dq/dt = q (0, w) / 2; body axes: dp/dt =
/// R(q) (v + a t), world axes: dp/dt = v + a t.
DisState integrate(const DisState& from,
                   bool turns,
                   bool accelerates,
                   bool body,
                   double elapsed_s) {
    const int steps = 400;
    const double h = elapsed_s / steps;
    const double node = std::sqrt(0.6);
    DisState to = from;
    const Vec3d w = turns ? from.angular_velocity : Vec3d(Vec3d::Zero());
    const Vec3d a = accelerates ? from.acceleration : Vec3d(Vec3d::Zero());
    const auto rate = [&](const Eigen::Quaterniond& q) {
        return Eigen::Vector4d((q * Eigen::Quaterniond(0.0, w.x(), w.y(), w.z())).coeffs() * 0.5);
    };
    // The Taylor series of q over a step needs no angle function either: repeated derivatives.
    const auto advance = [&](const Eigen::Quaterniond& q, double dt) {
        Eigen::Vector4d sum = q.coeffs();
        Eigen::Vector4d term = q.coeffs();
        for (int k = 1; k <= 10; ++k) {
            term = rate(Eigen::Quaterniond(term)) * (dt / k);
            sum += term;
        }
        return Eigen::Quaterniond(sum);
    };
    for (int i = 0; i < steps; ++i) {
        const double points[3] = {0.5 * (1.0 - node), 0.5, 0.5 * (1.0 + node)};
        const double weights[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
        Vec3d moved = Vec3d::Zero();
        for (int k = 0; k < 3; ++k) {
            const Vec3d v = from.velocity + a * (h * (i + points[k]));
            moved += weights[k] * (body ? advance(to.orientation, h * points[k]) * v : v);
        }
        to.position += h * moved;
        to.orientation = advance(to.orientation, h);
    }
    return to;
}

struct Case {
    DisAlgorithm algorithm;
    bool turns;
    bool accelerates;
    bool body;
};

constexpr Case kCases[] = {{DisAlgorithm::kFpw, false, false, false},
                           {DisAlgorithm::kRpw, true, false, false},
                           {DisAlgorithm::kRvw, true, true, false},
                           {DisAlgorithm::kFvw, false, true, false},
                           {DisAlgorithm::kFpb, false, false, true},
                           {DisAlgorithm::kRpb, true, false, true},
                           {DisAlgorithm::kRvb, true, true, true},
                           {DisAlgorithm::kFvb, false, true, true}};

// The step's error of the integrator is about (|w| h)^6 / 5e5 of what it moves: with 400 steps over
// 2 s and 7 rad/s at most it is below 1e-13 m; rounding of 100 m over 400 steps is below 1e-11.
TEST(DisAlgorithms, AgreeWithAHighOrderIntegratorOfTheEquationsOfMotion) {
    core::Rng rng(1);
    for (int n = 0; n < 100; ++n) {
        // From no turn at all over the series' range to far beyond it.
        const float spin = n % 4 == 0 ? 1e-6F : n % 4 == 1 ? 1e-2F : n % 4 == 2 ? 0.5F : 4.0F;
        const DisState from = any_state(rng, spin);
        const double t = static_cast<double>(rng.range(0.01F, 2.0F));
        for (const Case& c : kCases) {
            const DisState expected = integrate(from, c.turns, c.accelerates, c.body, t);
            const DisState got = dis_predict(from, c.algorithm, t);
            EXPECT_LT((got.position - expected.position).norm(), kTolerance);
            EXPECT_LT((got.orientation.coeffs() - expected.orientation.coeffs()).norm(),
                      kTolerance);
        }
    }
}

TEST(DisAlgorithms, StaticStaysAsItWas) {
    core::Rng rng(2);
    const DisState from = any_state(rng, 3.0F);
    const DisState to = dis_predict(from, DisAlgorithm::kStatic, 5.0);
    EXPECT_EQ(to.position, from.position);
    EXPECT_EQ(to.orientation.coeffs(), from.orientation.coeffs());
}

// A body that drives ahead at v while it turns about up at w goes round a circle of radius v / w;
// one that speeds up by a as well goes along an involute-like spiral with the closed form below.
TEST(DisAlgorithms, BodyAxesGoRoundTheCircleAndTheSpiralOfTheClosedForm) {
    core::Rng rng(3);
    for (int n = 0; n < 1000; ++n) {
        DisState from;
        const double v = static_cast<double>(rng.range(0.1F, 30.0F));
        const double a = static_cast<double>(rng.range(-5.0F, 5.0F));
        const double w = static_cast<double>(rng.range(0.5F, 6.0F));
        const double t = static_cast<double>(rng.range(0.1F, 3.0F));
        from.velocity = Vec3d(0.0, 0.0, v);  // ahead is +z; a turn about +y leads towards +x
        from.acceleration = Vec3d(0.0, 0.0, a);
        from.angular_velocity = Vec3d(0.0, w, 0.0);
        const double s = std::sin(w * t);
        const double c = std::cos(w * t);
        const Vec3d circle(v / w * (1.0 - c), 0.0, v / w * s);
        EXPECT_LT((dis_predict(from, DisAlgorithm::kRpb, t).position - circle).norm(), kTolerance);
        // Integrals of s sin(w s) and s cos(w s).
        const Vec3d spiral(a * (s - w * t * c) / (w * w), 0.0, a * (c + w * t * s - 1.0) / (w * w));
        EXPECT_LT((dis_predict(from, DisAlgorithm::kRvb, t).position - circle - spiral).norm(),
                  kTolerance);
    }
}

TEST(DisAlgorithms, WorldAxesFollowTheParabolaWhateverTheBodyDoes) {
    core::Rng rng(4);
    for (int n = 0; n < 1000; ++n) {
        const DisState from = any_state(rng, 4.0F);
        const double t = static_cast<double>(rng.range(0.0F, 5.0F));
        const Vec3d parabola = from.position + from.velocity * t + 0.5 * from.acceleration * t * t;
        EXPECT_LT((dis_predict(from, DisAlgorithm::kRvw, t).position - parabola).norm(),
                  kTolerance);
        EXPECT_LT((dis_predict(from, DisAlgorithm::kFvw, t).position - parabola).norm(),
                  kTolerance);
    }
}

// Series and closed form meet at 1.5 rad; over the seam every integral is as smooth as its
// derivative allows (all are below 1 in slope), and small angles reach their limits.
TEST(TurnIntegrals, PassTheSeamBetweenSeriesAndClosedFormWithoutAStep) {
    const double eps = 1e-12;
    const TurnIntegrals below = turn_integrals(1.5 - eps);
    const TurnIntegrals above = turn_integrals(1.5);
    EXPECT_NEAR(below.sine, above.sine, 4.0 * eps);
    EXPECT_NEAR(below.versine, above.versine, 4.0 * eps);
    EXPECT_NEAR(below.arc, above.arc, 4.0 * eps);
    EXPECT_NEAR(below.sagitta, above.sagitta, 4.0 * eps);
    const TurnIntegrals none = turn_integrals(0.0);
    EXPECT_DOUBLE_EQ(none.sine, 1.0);
    EXPECT_DOUBLE_EQ(none.versine, 0.5);
    EXPECT_DOUBLE_EQ(none.arc, 1.0 / 6.0);
    EXPECT_DOUBLE_EQ(none.sagitta, 1.0 / 24.0);
    EXPECT_DOUBLE_EQ(none.first_cosine, 0.5);
    EXPECT_DOUBLE_EQ(none.first_sine, 1.0 / 3.0);
    EXPECT_DOUBLE_EQ(none.first_rest, 0.125);
}

}  // namespace
}  // namespace zoned::motion
