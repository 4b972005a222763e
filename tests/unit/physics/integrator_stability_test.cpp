// build: computes
// Integrators: the steps at which they are stable, and refused settings.
#include "server/physics/integrator/stability.h"
#include "tests/unit/physics/integrator_test.h"

#include <algorithm>
#include <numbers>

namespace zoned::physics {
namespace {

using scenario::Line;
using scenario::SwayingSpring;

constexpr std::array kExplicit{IntegratorKind::kDefault,
                               IntegratorKind::kExplicitEuler,
                               IntegratorKind::kSemiImplicitEuler,
                               IntegratorKind::kVerlet,
                               IntegratorKind::kVelocityVerlet,
                               IntegratorKind::kRk2,
                               IntegratorKind::kRk4};

/// The largest |x| of a run from x = 1 at rest; ends early beyond a million.
double farthest(IntegratorKind kind, double omega, double damping_ratio, double h, long steps) {
    const SwayingSpring spring{omega, damping_ratio, 0.0, 0.0};
    return with_integrator<Line>(kind, [&](auto method) {
        MotionState<Line> s{Line(1.0), Line(0.0)};
        method.start(s.x, s.v, 0.0, h, spring);
        double most = 0.0;
        for (long i = 0; i < steps && most < 1e6; ++i) {
            method.step(s.x, s.v, static_cast<double>(i) * h, h, spring);
            most = std::max(most, std::abs(s.x[0]));
        }
        return most;
    });
}

/// Just below the limit nothing grows in 200,000 steps. The growth of one step before it decays is
/// bounded: an eigenvector's share, below a hundred here. Just beyond the limit everything
/// explodes.
TEST(StabilityLimit, IsWhereMethodsBlowUp) {
    constexpr double kOmega = 30.0;
    for (const IntegratorKind kind : kExplicit) {
        for (const double ratio : {0.0, 0.05, 0.3, 1.0, 3.0}) {
            const StabilityLimit limit = stability_limit(kind, kOmega, ratio);
            SCOPED_TRACE(std::string(name_of(kind)) + " " + std::to_string(ratio));
            EXPECT_EQ(limit.piece_s, limit.step_s);
            if (limit.step_s == 0.0) {
                EXPECT_EQ(ratio, 0.0);
                EXPECT_GT(farthest(kind, kOmega, ratio, 0.4 / kOmega, 200'000), 1e6);
                continue;
            }
            EXPECT_LT(farthest(kind, kOmega, ratio, 0.97 * limit.step_s, 200'000), 100.0);
            EXPECT_GE(farthest(kind, kOmega, ratio, 1.03 * limit.step_s, 200'000), 1e6);
        }
    }
}

TEST(StabilityLimit, HasTheKnownValues) {
    const auto limit = [](IntegratorKind kind, double ratio) {
        return stability_limit(kind, 1.0, ratio).step_s;
    };
    EXPECT_EQ(limit(IntegratorKind::kExplicitEuler, 0.0), 0.0);
    EXPECT_EQ(limit(IntegratorKind::kRk2, 0.0), 0.0);
    EXPECT_EQ(limit(IntegratorKind::kDefault, 0.0), 0.0);
    EXPECT_EQ(limit(IntegratorKind::kSemiImplicitEuler, 0.0), 2.0);
    EXPECT_EQ(limit(IntegratorKind::kVerlet, 0.0), 2.0);
    EXPECT_NEAR(limit(IntegratorKind::kVelocityVerlet, 0.0), 2.0, 1e-6);
    EXPECT_NEAR(limit(IntegratorKind::kRk4, 0.0), 2.0 * std::numbers::sqrt2, 1e-6);
    EXPECT_EQ(limit(IntegratorKind::kImplicitEuler, 0.0), StabilityLimit::kAny);
    EXPECT_NEAR(limit(IntegratorKind::kExplicitEuler, 1.0), 2.0, 1e-12);
    // On the negative real axis: Hairer, Wanner, "Solving ODE II", IV.2, figures 2.1 and 2.2.
    EXPECT_NEAR(drag_limit(IntegratorKind::kRk4, 2.0).step_s, 2.785 / 2, 1e-3);
    EXPECT_NEAR(drag_limit(IntegratorKind::kAdaptive, 1.0).piece_s, 3.307, 1e-3);
    EXPECT_EQ(drag_limit(IntegratorKind::kAdaptive, 1.0).step_s, StabilityLimit::kAny);
    EXPECT_EQ(drag_limit(IntegratorKind::kDefault, 1e4).step_s, StabilityLimit::kAny);
}

TEST(StabilityLimit, IsWhereADragBlowsUp) {
    constexpr double kStrongDrag = 50.0;
    const FreeFall<double, 1> air(Line(0.0), kStrongDrag);
    for (const IntegratorKind kind : kIntegratorKinds) {
        const double limit = drag_limit(kind, kStrongDrag).step_s;
        const auto speed = [&](double h) {
            const MotionState<Line> start{Line(0.0), Line(1.0)};
            return std::abs(run_motion(kind, start, h, 2000, air).v[0]);
        };
        if (limit == StabilityLimit::kAny) {
            EXPECT_LE(speed(100.0 / kStrongDrag), 1.0) << name_of(kind);
            continue;
        }
        EXPECT_LE(speed(0.97 * limit), 1.0) << name_of(kind);
        EXPECT_GT(speed(1.03 * limit), 1e6) << name_of(kind);
    }
}

/// k dt^2 / m = 10^4: implicit Euler loses energy in every step, by the factor 1 / (1 + w^2) where
/// nothing else damps. Damping only adds to that in the long run (its matrix is not normal).
TEST(ImplicitEuler, IsStableOnASpringThatNoExplicitMethodBears) {
    constexpr double kH = 1.0 / 60;
    constexpr double kOmega = 100.0 / kH;
    for (const double ratio : {0.0, 0.1, 1.0}) {
        EXPECT_EQ(why_unstable(IntegratorKind::kImplicitEuler, kOmega, ratio, kH), "");
        const SwayingSpring spring{kOmega, ratio, 0.0, 0.0};
        MotionState<Line> s{Line(0.1), Line(5.0)};
        ImplicitEuler<Line> method;
        double energy = spring.energy(s);
        for (int i = 0; i < 20; ++i) {
            method.step(s.x, s.v, 0.0, kH, spring);
            const double after = spring.energy(s);
            EXPECT_LT(after, energy);
            if (ratio == 0.0) {
                EXPECT_NEAR(after / energy * (1 + 1e4), 1.0, 1e-9);
            }
            energy = after;
        }
        EXPECT_LT(energy, 1e-60);
        EXPECT_EQ(method.unsolved, 0U);
        for (const IntegratorKind kind : kExplicit) {
            EXPECT_NE(why_unstable(kind, kOmega, ratio, kH), "") << name_of(kind);
        }
    }
    const std::string reason = why_unstable(IntegratorKind::kRk4, kOmega, 0.1, kH);
    EXPECT_NE(reason.find("rk4: a spring of 6000 rad/s with damping ratio 0.1"), std::string::npos)
        << reason;
}

/// The adaptive pair bears the spring by cutting the step; the limit says into how many pieces at
/// the least where the motion has died down.
TEST(Adaptive, BearsAStiffSpringByCuttingItsStep) {
    constexpr double kH = 1.0 / 60;
    constexpr double kOmega = 100.0 / kH;
    EXPECT_EQ(why_unstable(IntegratorKind::kAdaptive, kOmega, 0.5, kH), "");
    const SwayingSpring spring{kOmega, 0.5, 0.0, 0.0};
    Adaptive<Line> method;
    const auto end = carried(method, MotionState<Line>{Line(1e-3), Line(0.0)}, kH, 60, spring);
    EXPECT_FALSE(method.report.gave_up);
    EXPECT_LT(std::abs(end.x[0]), 1e-6);
    const double least = 60 * kH / stability_limit(IntegratorKind::kAdaptive, kOmega, 0.5).piece_s;
    EXPECT_GT(static_cast<double>(method.report.pieces), 0.8 * least);
    EXPECT_LT(static_cast<double>(method.report.pieces), 3.0 * least);
}

}  // namespace
}  // namespace zoned::physics
