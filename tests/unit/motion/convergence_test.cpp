#include "shared/motion/convergence.h"

#include "tests/unit/motion/random_vector.h"
#include "shared/core/rng.h"
#include "shared/motion/dead_reckoning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace zoned::motion {
namespace {

constexpr ConvergenceMethod kMethods[] = {ConvergenceMethod::kSnap,
                                          ConvergenceMethod::kLinear,
                                          ConvergenceMethod::kProjectiveVelocity,
                                          ConvergenceMethod::kHermite};
static_assert(std::size(kMethods) == kConvergenceMethods);
/// Those that take over position and velocity.
constexpr ConvergenceMethod kSmooth[] = {ConvergenceMethod::kProjectiveVelocity,
                                         ConvergenceMethod::kHermite};

KinematicState any_state(core::Rng& rng) {
    KinematicState state;
    state.position = random_vector(rng, 50.0F);
    state.orientation =
        Quat(Eigen::AngleAxisf(rng.range(0.0F, 3.1F), random_vector(rng, 1.0F).normalized()));
    state.velocity = random_vector(rng, 10.0F);
    state.acceleration = random_vector(rng, 10.0F);
    state.angular_velocity = random_vector(rng, 3.0F);
    state.turn = random_vector(rng, 4.0F);
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
          order(static_cast<PredictorOrder>(rng.below(kPredictorOrders))),
          period_s(rng.range(0.05F, 1.0F)) {
        published.position = shown.position + random_vector(rng, 3.0F);
        convergence.begin(shown, published, period_s);
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
             {ConvergenceMethod::kLinear, kSmooth[0], kSmooth[1]}) {
            const KinematicState at_start = c.displayed(method, 0.0F);
            EXPECT_LT((at_start.position - c.shown.position).norm(), kRounding);
            EXPECT_LT(angle_between(at_start.orientation, c.shown.orientation), 3e-6F);
        }
        for (const ConvergenceMethod method : kSmooth) {
            // Order 0 has no velocity of its own to be continued from.
            const Vec3 start = c.displayed(method, 0.0F).velocity;
            const Vec3 offset = c.predicted(0.0F).velocity - c.published.velocity;
            EXPECT_LT((start - c.shown.velocity - offset).norm(), 1e-4F);
        }
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
        // The smooth methods arrive with the predicted velocity: no kink at the end. Their second
        // derivative is at most (6 jump / T^2 + 6 dv / T), times the last thousandth of T.
        const float t = 0.999F * c.period_s;
        const float jump = (c.shown.position - c.published.position).norm();
        const float dv = (c.shown.velocity - c.published.velocity).norm();
        for (const ConvergenceMethod method : kSmooth) {
            const KinematicState nearly = c.displayed(method, t);
            EXPECT_LT((nearly.velocity - c.predicted(t).velocity).norm(),
                      0.001F * (6.0F * jump / c.period_s + 6.0F * dv) + 1e-4F);
        }
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
    c.convergence.begin(c.shown, c.published, 0.0F);
    for (const ConvergenceMethod method : kMethods) {
        EXPECT_EQ(c.displayed(method, 0.0F).position, c.published.position);
        EXPECT_EQ(Convergence::remaining_error(method, 1.0F, 0.0F, 0.0F, 1.0F), 0.0F);
    }
}

TEST(Convergence, NeverShowsMoreErrorThanItDeclaresAsRemaining) {
    core::Rng rng(5);
    for (int i = 0; i < 2000; ++i) {
        const Correction c(rng);
        const float jump = (c.shown.position - c.published.position).norm();
        const float velocity_jump = (c.shown.velocity - c.published.velocity).norm();
        for (const ConvergenceMethod method : kMethods) {
            for (int k = 0; k <= 24; ++k) {
                const float t = c.period_s * static_cast<float>(k) / 20.0F;
                const float error =
                    (c.displayed(method, t).position - c.predicted(t).position).norm();
                const float remaining =
                    Convergence::remaining_error(method, jump, t, c.period_s, velocity_jump);
                EXPECT_LE(error, remaining + kRounding);
                if (method == ConvergenceMethod::kLinear) {
                    EXPECT_LE(remaining, jump * std::max(0.0F, 1.0F - t / c.period_s) + 1e-6F);
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
             {ConvergenceMethod::kLinear, kSmooth[0], kSmooth[1]}) {
            if (c.order == PredictorOrder::kBallistic) {
                continue;  // nothing has a velocity where it lands
            }
            const float t = c.period_s * rng.range(0.1F, 0.9F);
            const float h = 0.02F * c.period_s;
            const Vec3 difference =
                (c.displayed(method, t + h).position - c.displayed(method, t - h).position) /
                (2.0F * h);
            // Central difference: h^2 / 6 times the third derivative, which is at most 12 jump /
            // T^3 + 18 dv / T^2, and |w|^2 a of an acceleration that turns, plus rounding of
            // positions over 2 h.
            const float jump = (c.shown.position - c.published.position).norm();
            const float dv = (c.shown.velocity - c.published.velocity).norm();
            const float turning =
                c.published.turn.squaredNorm() * c.published.acceleration.norm() * h * h / 6.0F;
            const float allowed =
                0.0004F / 6.0F * (12.0F * jump / c.period_s + 18.0F * dv) + kRounding / h + turning;
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

/// The largest third difference of displayed - predicted over a blend, m/s3.
float measured_jerk(ConvergenceMethod method, const Vec3& jump, const Vec3& dv, float period_s) {
    KinematicState published;
    KinematicState shown;
    shown.position = jump;
    shown.velocity = dv;
    Convergence convergence;
    convergence.begin(shown, published, period_s);
    const int steps = 64;
    const float h = period_s / static_cast<float>(steps);
    float most = 0.0F;
    for (int k = 0; k + 3 < steps; ++k) {
        Vec3d p[4];
        for (int j = 0; j < 4; ++j) {
            const float t = static_cast<float>(k + j) * h;
            p[j] = convergence.display(method, published, t).position.cast<double>();
        }
        const Vec3d third = (p[3] - 3.0 * p[2] + 3.0 * p[1] - p[0]) / std::pow(h, 3);
        most = std::max(most, static_cast<float>(third.norm()));
    }
    return most;
}

/// The closed form of the largest jerk of displayed - predicted within the blend, m/s3: 12 jump /
/// T^3 plus 18 (kProjectiveVelocity) or 6 (kHermite) velocity_jump / T^2. Infinite where the
/// displayed velocity jumps (kSnap, kLinear), unless nothing does.
float largest_jerk(ConvergenceMethod method,
                   float jump_m,
                   float period_s,
                   float velocity_jump_mps) {
    if (jump_m == 0.0F && velocity_jump_mps == 0.0F) {
        return 0.0F;
    }
    const float of_position = 12.0F * jump_m / (period_s * period_s * period_s);
    const float of_velocity = velocity_jump_mps / (period_s * period_s);
    switch (method) {
        case ConvergenceMethod::kSnap:
        case ConvergenceMethod::kLinear:
            break;
        case ConvergenceMethod::kProjectiveVelocity:
            // The third derivative of T s (1 - s)^3 (1 + 2 s) is (-18 + 120 s - 120 s^2) / T^2.
            return of_position + 18.0F * of_velocity;
        case ConvergenceMethod::kHermite:
            return of_position + 6.0F * of_velocity;
    }
    return std::numeric_limits<float>::infinity();
}

// The standard jump: 0.3 m and 2 m/s along one line within 0.2 s, where the parts of the closed
// form add up. Third differences of floats near 1: 8 roundings of 6e-8 over h^3 = 3e-8 s3.
TEST(Convergence, CostsTheJerkOfItsClosedForm) {
    const Vec3 ahead(1.0F, 0.0F, 0.0F);
    const float rounding = 20.0F;
    for (const ConvergenceMethod method : kSmooth) {
        const float only_place = measured_jerk(method, 0.3F * ahead, Vec3::Zero(), 0.2F);
        EXPECT_NEAR(only_place, largest_jerk(method, 0.3F, 0.2F, 0.0F), rounding);
        const float only_velocity = measured_jerk(method, Vec3::Zero(), 2.0F * ahead, 0.2F);
        const float declared = largest_jerk(method, 0.0F, 0.2F, 2.0F);
        EXPECT_LE(only_velocity, declared + rounding);
        // The largest value is at the very start, which a difference only nears.
        EXPECT_GE(only_velocity, 0.8F * declared - rounding);
        const float both = measured_jerk(method, 0.3F * ahead, 2.0F * ahead, 0.2F);
        EXPECT_LE(both, largest_jerk(method, 0.3F, 0.2F, 2.0F) + rounding);
    }
    EXPECT_LT(largest_jerk(ConvergenceMethod::kHermite, 0.3F, 0.2F, 2.0F),
              largest_jerk(ConvergenceMethod::kProjectiveVelocity, 0.3F, 0.2F, 2.0F));
    EXPECT_TRUE(std::isinf(largest_jerk(ConvergenceMethod::kSnap, 0.3F, 0.2F, 0.0F)));
    EXPECT_TRUE(std::isinf(largest_jerk(ConvergenceMethod::kLinear, 0.3F, 0.2F, 0.0F)));
}

}  // namespace
}  // namespace zoned::motion
