#include "shared/motion/convergence.h"

#include "tests/unit/motion/random_vector.h"
#include "shared/core/rng.h"
#include "shared/motion/dead_reckoning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace zoned::motion {
namespace {

constexpr ConvergenceMethod kMethods[] = {ConvergenceMethod::kSnap,
                                          ConvergenceMethod::kLinear,
                                          ConvergenceMethod::kProjectiveVelocity};
constexpr PredictorOrder kOrders[] = {PredictorOrder::kStatic,
                                      PredictorOrder::kLinear,
                                      PredictorOrder::kQuadratic};

KinematicState any_state(core::Rng& rng) {
    KinematicState state;
    state.position = random_vector(rng, 50.0F);
    state.orientation =
        Quat(Eigen::AngleAxisf(rng.range(0.0F, 3.1F), random_vector(rng, 1.0F).normalized()));
    state.velocity = random_vector(rng, 10.0F);
    state.acceleration = random_vector(rng, 10.0F);
    state.angular_velocity = random_vector(rng, 3.0F);
    return state;
}

/// A view that showed one thing when a publication that says another arrived.
struct Correction {
    KinematicState shown;
    KinematicState published;  // at begin()
    PredictorOrder order = PredictorOrder::kLinear;
    float period_s = 0.2F;
    Convergence convergence;

    explicit Correction(core::Rng& rng)
        : shown(any_state(rng)),
          published(any_state(rng)),
          order(kOrders[rng.below(3)]),
          period_s(rng.range(0.05F, 1.0F)) {
        published.position = shown.position + random_vector(rng, 3.0F);
        convergence.begin(shown, period_s);
    }

    KinematicState predicted(float t) const { return predict(published, order, t); }

    KinematicState displayed(ConvergenceMethod method, float t) const {
        return convergence.display(method, predicted(t), t);
    }
};

// Positions up to some 100 m: a few roundings of 2^-24 of that.
constexpr float kRounding = 5e-5F;

TEST(Convergence, SmoothMethodsStartWhereTheEntityWasShown) {
    core::Rng rng(1);
    for (int i = 0; i < 500; ++i) {
        const Correction c(rng);
        for (const ConvergenceMethod method :
             {ConvergenceMethod::kLinear, ConvergenceMethod::kProjectiveVelocity}) {
            const KinematicState at_start = c.displayed(method, 0.0F);
            EXPECT_LT((at_start.position - c.shown.position).norm(), kRounding);
            EXPECT_LT(angle_between(at_start.orientation, c.shown.orientation), 3e-6F);
        }
        EXPECT_LT(
            (c.displayed(ConvergenceMethod::kProjectiveVelocity, 0.0F).velocity - c.shown.velocity)
                .norm(),
            1e-4F);
    }
}

TEST(Convergence, EndsExactlyOnThePrediction) {
    core::Rng rng(2);
    for (int i = 0; i < 100; ++i) {
        const Correction c(rng);
        for (const ConvergenceMethod method : kMethods) {
            for (const float t : {c.period_s, c.period_s * 1.5F}) {
                const KinematicState end = c.displayed(method, t);
                EXPECT_EQ(end.position, c.predicted(t).position);
                EXPECT_EQ(end.velocity, c.predicted(t).velocity);
                EXPECT_EQ(end.orientation.coeffs(), c.predicted(t).orientation.coeffs());
            }
        }
        // Projective velocity blending arrives with the predicted velocity: no kink at the end. Its
        // second derivative is at most (6 jump / T^2 + 6 dv / T), times the last thousandth of T.
        const float t = 0.999F * c.period_s;
        const KinematicState nearly = c.displayed(ConvergenceMethod::kProjectiveVelocity, t);
        const float jump = (c.shown.position - c.predicted(0).position).norm();
        const float dv = (c.shown.velocity - c.predicted(0).velocity).norm();
        EXPECT_LT((nearly.velocity - c.predicted(t).velocity).norm(),
                  0.001F * (6.0F * jump / c.period_s + 6.0F * dv) + 1e-4F);
    }
}

TEST(Convergence, SnapShowsThePredictionAtOnce) {
    core::Rng rng(3);
    const Correction c(rng);
    EXPECT_EQ(c.displayed(ConvergenceMethod::kSnap, 0.0F).position, c.published.position);
}

TEST(Convergence, APeriodOfZeroIsASnap) {
    core::Rng rng(4);
    Correction c(rng);
    c.convergence.begin(c.shown, 0.0F);
    for (const ConvergenceMethod method : kMethods) {
        EXPECT_EQ(c.displayed(method, 0.0F).position, c.published.position);
        EXPECT_EQ(Convergence::owed(method, 1.0F, 0.0F, 0.0F, 1.0F), 0.0F);
    }
}

TEST(Convergence, NeverShowsMoreErrorThanItDeclaresAsOwed) {
    core::Rng rng(5);
    for (int i = 0; i < 2000; ++i) {
        const Correction c(rng);
        const float jump = (c.shown.position - c.predicted(0.0F).position).norm();
        const float velocity_jump = (c.shown.velocity - c.predicted(0.0F).velocity).norm();
        for (const ConvergenceMethod method : kMethods) {
            for (int k = 0; k <= 24; ++k) {
                const float t = c.period_s * static_cast<float>(k) / 20.0F;
                const float error =
                    (c.displayed(method, t).position - c.predicted(t).position).norm();
                const float owed = Convergence::owed(method, jump, t, c.period_s, velocity_jump);
                EXPECT_LE(error, owed + kRounding);
                if (method == ConvergenceMethod::kLinear) {
                    EXPECT_LE(owed, jump * std::max(0.0F, 1.0F - t / c.period_s) + 1e-6F);
                }
            }
        }
    }
}

TEST(Convergence, DisplayedVelocityIsTheDerivativeOfDisplayedPosition) {
    core::Rng rng(6);
    for (int i = 0; i < 300; ++i) {
        const Correction c(rng);
        for (const ConvergenceMethod method :
             {ConvergenceMethod::kLinear, ConvergenceMethod::kProjectiveVelocity}) {
            const float t = c.period_s * rng.range(0.1F, 0.9F);
            const float h = 0.02F * c.period_s;
            const Vec3 difference =
                (c.displayed(method, t + h).position - c.displayed(method, t - h).position) /
                (2.0F * h);
            // Central difference: h^2 / 6 times the third derivative, which is at most 12 jump /
            // T^3
            // + 18 dv / T^2, plus rounding of positions over 2 h.
            const float jump = (c.shown.position - c.predicted(0).position).norm();
            const float dv = (c.shown.velocity - c.predicted(0).velocity).norm();
            const float allowed =
                0.0004F / 6.0F * (12.0F * jump / c.period_s + 18.0F * dv) + kRounding / h;
            EXPECT_LT((c.displayed(method, t).velocity - difference).norm(), allowed);
        }
    }
}

TEST(Convergence, OrientationApproachesThePredictionByTheShorterWay) {
    core::Rng rng(7);
    for (int i = 0; i < 300; ++i) {
        const Correction c(rng);
        const float jump = angle_between(c.shown.orientation, c.predicted(0).orientation);
        float before = jump;
        for (int k = 1; k <= 20; ++k) {
            const float t = c.period_s * static_cast<float>(k) / 20.0F;
            const float error = angle_between(
                c.displayed(ConvergenceMethod::kLinear, t).orientation, c.predicted(t).orientation);
            EXPECT_NEAR(error, jump * std::max(0.0F, 1.0F - t / c.period_s), 1e-5F);
            EXPECT_LE(error, before + 1e-5F);
            before = error;
        }
    }
}

}  // namespace
}  // namespace zoned::motion
