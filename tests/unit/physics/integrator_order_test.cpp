// Integrators: order of convergence, exactness, tolerance, Newton's method.
#include "tests/unit/physics/integrator_test.h"

#include <limits>
#include <numbers>

namespace zoned::physics {
namespace {

using scenario::Line;
using scenario::Orbit;
using scenario::Pendulum;
using scenario::SwayingSpring;
using scenario::ThrownBall;

/// Halving h divides an error C h^p (1 + c h) by 2^p (1 + c h / 2), which shows p up to c h / 1.4.
/// With the steps below c h stays under 0.1 for these motions, which gives the tolerance.
constexpr double kOrderTolerance = 0.1;

/// Time and velocity are in the force, so that a stage at a wrong time or velocity costs an order.
TEST(Integrators, ConvergeOnADrivenDampedSpringWithTheOrderOfTheory) {
    const SwayingSpring spring{2.0, 0.3, 0.5, 1.3};
    const MotionState<Line> start{Line(1.0), Line(-0.4)};
    const MotionState<Line> exact = spring.exact(start, 1.7);
    for (const auto& [kind, order] : kOrders) {
        const long steps = order == 4 ? 100 : 800;
        const auto error = [&](long n) {
            return apart(run_motion(kind, start, 1.7 / static_cast<double>(n), n, spring), exact);
        };
        EXPECT_NEAR(std::log2(error(steps) / error(2 * steps)), order, kOrderTolerance)
            << name_of(kind);
    }
}

TEST(Integrators, ConvergeOnAnOrbitWithTheOrderOfTheory) {
    const MotionState<scenario::Plane> start = Orbit::exact(0.3, 0.0);
    const MotionState<scenario::Plane> exact = Orbit::exact(0.3, 2.0);
    for (const auto& [kind, order] : kOrders) {
        const long steps = order == 4 ? 200 : 3200;
        const auto error = [&](long n) {
            return apart(run_motion(kind, start, 2.0 / static_cast<double>(n), n, Orbit()), exact);
        };
        EXPECT_NEAR(std::log2(error(steps) / error(2 * steps)), order, kOrderTolerance)
            << name_of(kind);
    }
}

/// The closed forms, which are the reference for everything here, against the equation of motion.
/// The central difference of v is the acceleration up to d^2 / 6 of its second derivative and
/// rounding.
TEST(Motions, SolveTheirEquations) {
    constexpr double kD = 1e-4;
    const auto check = [](const auto& force, const auto& exact, double t) {
        const auto before = exact(t - kD);
        const auto now = exact(t);
        const auto after = exact(t + kD);
        EXPECT_LT((after.x - before.x - 2 * kD * now.v).norm() / (2 * kD), 1e-6);
        EXPECT_LT(((after.v - before.v) / (2 * kD) - force(now.x, now.v, t)).norm(), 1e-6);
    };
    const SwayingSpring spring{2.0, 0.3, 0.5, 1.3};
    const Pendulum pendulum;
    const ThrownBall ball;
    for (const double t : {0.3, 1.9, 4.4, 17.0}) {
        const auto swayed = [&](double at) {
            return spring.exact({Line(1.0), Line(-0.4)}, at);
        };
        check(spring, swayed, t);
        check(
            Orbit(), [](double at) { return Orbit::exact(0.6, at); }, t);
        check(
            pendulum, [&](double at) { return pendulum.exact(2.8, at); }, t);
        check(
            ball, [&](double at) { return ball.dropped(at); }, t);
    }
    EXPECT_NEAR(pendulum.exact(2.8, 0.0).x[0], 2.8, 1e-12);
    EXPECT_NEAR(Orbit::exact(0.6, 0.0).x.x(), 0.4, 1e-12);
}

/// Errors of n steps of h under constant acceleration: g h t / 2 for the Euler methods, none but
/// rounding for the others: n roundings of numbers up to 500, 1e-13 each.
TEST(Integrators, AreExactUnderConstantAccelerationWhereTheyShouldBe) {
    const FreeFall<double, 3> fall(Vec3d(0, -9.81, 0), 0.0);
    constexpr double kH = 1.0 / 60;
    constexpr long kSteps = 600;
    const double t = kH * kSteps;
    const MotionState<Vec3d> start{Vec3d(1, 2, 3), Vec3d(4, 50, -6)};
    for (const IntegratorKind kind : kIntegratorKinds) {
        double off = 0.0;
        if (kind == IntegratorKind::kExplicitEuler) {
            off = 0.5 * 9.81 * kH * t;
        } else if (kind == IntegratorKind::kImplicitEuler ||
                   kind == IntegratorKind::kSemiImplicitEuler) {
            off = -0.5 * 9.81 * kH * t;
        }
        const Vec3d exact(1 + 4 * t, 2 + 50 * t - 0.5 * 9.81 * t * t + off, 3 - 6 * t);
        const MotionState<Vec3d> end = run_motion(kind, start, kH, kSteps, fall);
        EXPECT_LT((end.x - exact).norm(), 1e-10) << name_of(kind);
        EXPECT_LT((end.v - Vec3d(4, 50 - 9.81 * t, -6)).norm(), 1e-10) << name_of(kind);
    }
}

/// In floats as in doubles, but for 240 roundings of numbers up to 100, 4e-6 each at most.
TEST(Integrators, WorkInFloats) {
    const FreeFall<float, 3> fall(Vec3(0, -9.81F, 0), 0.2F);
    const FreeFall<double, 3> same(fall.pull(Vec3::Zero(), 0.0F).cast<double>(),
                                   static_cast<double>(fall.drag()));
    for (const IntegratorKind kind : kIntegratorKinds) {
        const double h = static_cast<double>(1.0F / 60);
        const auto end =
            run_motion(kind, MotionState<Vec3d>{Vec3d(0, 5, 0), Vec3d(10, 20, 0)}, h, 240, same);
        MotionState<Vec3> s{Vec3(0, 5, 0), Vec3(10, 20, 0)};
        with_integrator<Vec3>(kind, [&](auto method) {
            method.start(s.x, s.v, 0.0F, 1.0F / 60, fall);
            for (int i = 0; i < 240; ++i) {
                method.step(s.x, s.v, static_cast<float>(i) / 60, 1.0F / 60, fall);
            }
        });
        EXPECT_LT((s.x.cast<double>() - end.x).norm(), 1e-3) << name_of(kind);
        EXPECT_LT((s.v.cast<double>() - end.v).norm(), 1e-3) << name_of(kind);
    }
}

/// Each piece adds at most the tolerance. On this orbit an error in speed at the centre changes the
/// period by 3 x 1.7 of it. So it changes the place after a turn by 3 x 1.7 x 2 pi x 1.7 = 55 of
/// it.
TEST(Adaptive, KeepsItsToleranceOnAnOrbit) {
    const MotionState<scenario::Plane> start = Orbit::exact(0.5, 0.0);
    const MotionState<scenario::Plane> exact = Orbit::exact(0.5, 6.0);
    double before = 1.0;
    for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
        Adaptive<scenario::Plane> method;
        method.options = {tolerance, tolerance, 100'000};
        const auto end = carried(method, start, 6.0, 1, Orbit());
        ASSERT_FALSE(method.report.gave_up);
        EXPECT_EQ(method.report.reached, 6.0);
        const double error = apart(end, exact);
        EXPECT_LT(error, 55 * tolerance * static_cast<double>(method.report.pieces)) << tolerance;
        EXPECT_LT(error, 0.1 * before);  // it follows the tolerance down
        before = error;
    }
}

TEST(Adaptive, AgreesWithTheClosedFormOfAFallInAir) {
    const ThrownBall ball;
    Adaptive<Vec3d> method;
    method.options = {1e-13, 1e-13, 100'000};
    const auto end = carried(method, MotionState<Vec3d>{}, 0.5, 20, ball);
    EXPECT_LT(apart(end, ball.dropped(10.0)), 1e-9);
}

TEST(Adaptive, SaysWhenItGivesUp) {
    const SwayingSpring stiff{1e6, 0.5, 0.0, 0.0};
    Adaptive<Line> method;
    method.options.most_pieces = 50;
    const auto end = carried(method, MotionState<Line>{Line(1.0), Line(0.0)}, 1.0, 1, stiff);
    EXPECT_TRUE(method.report.gave_up);
    EXPECT_GT(method.report.reached, 0.0);
    EXPECT_LT(method.report.reached, 1.0);
    const auto exact = stiff.exact({Line(1.0), Line(0.0)}, method.report.reached);
    EXPECT_NEAR(end.x[0], exact.x[0], 1e-3);  // its result is good up to there

    Adaptive<Line> lost;
    const auto nowhere = [](const Line&, const Line&, double t) {
        return Line(t > 0.5 ? std::numeric_limits<double>::quiet_NaN() : 1.0);
    };
    const auto last = carried(lost, MotionState<Line>{}, 1.0, 1, nowhere);
    EXPECT_TRUE(lost.report.gave_up);
    EXPECT_NEAR(lost.report.reached, 0.5, 1e-9);
    EXPECT_NEAR(last.v[0], 0.5, 1e-9);
}

TEST(ImplicitEuler, NeedsOneIterationForALinearForceAndOneToSeeIt) {
    const SwayingSpring spring{6000.0, 0.1, 0.1, 6.28};
    const auto end_after = [&](int iterations) {
        ImplicitEuler<Line> method;
        method.iterations = iterations;
        const auto end =
            carried(method, MotionState<Line>{Line(0.01), Line(3.0)}, 1.0 / 60, 1, spring);
        EXPECT_EQ(method.unsolved, 0U);
        return end;
    };
    const auto once = end_after(1);
    const auto twice = end_after(2);
    EXPECT_LT(apart(once, twice), 1e-12);
    // v' (1 + 2 z w h + (w h)^2) = v + 2 z w h y' + w^2 h (y - x), all at the end of the step.
    const double w = 100.0;
    const double y = 0.1 * std::sin(6.28 / 60);
    const double slope = 0.628 * std::cos(6.28 / 60);
    const double v = (3.0 + 20.0 * slope + w * w * 60 * (y - 0.01)) / (1 + 20.0 + w * w);
    EXPECT_NEAR(once.v[0], v, 1e-10);
}

/// Without given derivatives, a force is differenced: the same answer, to the tolerance of Newton's
/// method.
TEST(ImplicitEuler, FindsDerivativesThatItIsNotTold) {
    const MotionState<Vec3d> start{Vec3d::Zero(), Vec3d(60, 40, -3)};
    const ThrownBall ball{9.81, 0.5};
    const auto untold = [&](const Vec3d& x, const Vec3d& v, double t) {
        return ball(x, v, t);
    };
    ImplicitEuler<Vec3d> told_method;
    ImplicitEuler<Vec3d> untold_method;
    const auto told = carried(told_method, start, 0.05, 40, ball);
    const auto differenced = carried(untold_method, start, 0.05, 40, untold);
    EXPECT_EQ(told_method.unsolved, 0U);
    EXPECT_EQ(untold_method.unsolved, 0U);
    EXPECT_LT(apart(told, differenced), 1e-11);
}

TEST(ImplicitEuler, ConvergesWithFirstOrderWhenLinearised) {
    const MotionState<Line> start{Line(2.0), Line(0.0)};
    const Pendulum pendulum;
    const auto error = [&](long n) {
        ImplicitEuler<Line> method;
        method.iterations = 1;
        return apart(carried(method, start, 1.0 / static_cast<double>(n), n, pendulum),
                     pendulum.exact(2.0, 1.0));
    };
    EXPECT_NEAR(std::log2(error(1600) / error(3200)), 1.0, kOrderTolerance);
}

TEST(ImplicitEuler, SaysWhenNewtonFindsNothing) {
    // v' = v + h (v'^2 + 1) has no solution for h = 1 and v = 0.
    const auto runaway = [](const Line&, const Line& v, double) {
        return Line(v[0] * v[0] + 1.0);
    };
    ImplicitEuler<Line> method;
    carried(method, MotionState<Line>{}, 1.0, 1, runaway);
    EXPECT_EQ(method.unsolved, 1U);
}

}  // namespace
}  // namespace zoned::physics
