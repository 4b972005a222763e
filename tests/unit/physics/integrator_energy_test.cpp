// Integrators: energy over many steps, and time turned round.
#include "tests/unit/physics/integrator_test.h"

#include <algorithm>

namespace zoned::physics {
namespace {

using scenario::Line;
using scenario::Orbit;
using scenario::Pendulum;
using scenario::SwayingSpring;

constexpr long kMany = 100'000;

/// Energies of a run: the largest relative errors in its first and its last tenth.
struct Swing {
    double first = 0.0;
    double last = 0.0;
};

template <class V, class A>
Swing swing(IntegratorKind kind, MotionState<V> s, double h, const A& a) {
    const double before = a.energy(s);
    Swing out;
    with_integrator<V>(kind, [&](auto method) {
        method.start(s.x, s.v, 0.0, h, a);
        for (long i = 0; i < kMany; ++i) {
            method.step(s.x, s.v, static_cast<double>(i) * h, h, a);
            const double off = std::abs(a.energy(s) / before - 1.0);
            out.first = i < kMany / 10 ? std::max(out.first, off) : out.first;
            out.last = i >= kMany - kMany / 10 ? std::max(out.last, off) : out.last;
        }
    });
    return out;
}

/// Symplectic Euler keeps v^2 + w^2 x^2 - h w^2 x v exactly (Hairer, Lubich, Wanner, IX.3). That
/// value lies within (1 -+ h w / 2) of twice the energy. Velocity Verlet keeps v^2 + w^2 (1 - (h w
/// / 2)^2) x^2. Rounding adds 1e5 x 1e-16.
TEST(SymplecticIntegrators, KeepTheEnergyOfAnOscillatorWithinTheoryAndDoNotDrift) {
    const SwayingSpring spring{1.0, 0.0, 0.0, 0.0};
    const MotionState<Line> start{Line(1.0), Line(0.0)};
    const double w = 0.2;
    const double first_order = (1 + w / 2) / (1 - w / 2) - 1;
    const double second_order = 1 / (1 - w * w / 4) - 1;
    const auto check = [&](IntegratorKind kind, double bound) {
        const Swing s = swing(kind, start, w, spring);
        EXPECT_LT(s.last, bound + 1e-10) << name_of(kind);
        EXPECT_GT(s.last, 0.2 * bound) << "the bound is of the right size: " << name_of(kind);
        EXPECT_LT(s.last, s.first + 1e-3 * bound) << name_of(kind);
    };
    check(IntegratorKind::kSemiImplicitEuler, first_order);
    check(IntegratorKind::kVelocityVerlet, second_order);
    // The central difference is velocity Verlet's velocity where forces know no velocity.
    check(IntegratorKind::kVerlet, second_order);
}

/// On nonlinear motions the same without constants: the swing of the last tenth is that of the
/// first, up to how steps fall on the orbit.
TEST(SymplecticIntegrators, DoNotDriftOnAnOrbitAndAPendulum) {
    for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler,
                                      IntegratorKind::kVelocityVerlet,
                                      IntegratorKind::kVerlet}) {
        const Swing orbit = swing(kind, Orbit::exact(0.3, 0.0), 0.02, Orbit());
        EXPECT_LT(orbit.last, 1.05 * orbit.first) << name_of(kind);
        EXPECT_LT(orbit.last, 0.05) << name_of(kind);
        const Swing pendulum =
            swing(kind, MotionState<Line>{Line(2.0), Line(0.0)}, 0.02, Pendulum());
        EXPECT_LT(pendulum.last, 1.05 * pendulum.first) << name_of(kind);
        EXPECT_LT(pendulum.last, 0.1) << name_of(kind);
    }
    // The check itself: a method of order four drifts.
    const Swing drifting = swing(IntegratorKind::kRk4, Orbit::exact(0.3, 0.0), 0.1, Orbit());
    EXPECT_GT(drifting.last, 2.0 * drifting.first);
}

/// |1 + i w|^2 = 1 + w^2 and so on: the factor of one step on the energy of an oscillator, to the
/// power of the number of steps; relative rounding of 1e-16 a step.
TEST(Integrators, GainAndLoseEnergyAsTheoryHasIt) {
    const SwayingSpring spring{2.0, 0.0, 0.0, 0.0};
    const MotionState<Line> start{Line(1.0), Line(0.5)};
    const double h = 0.02;
    const double w2 = 4.0 * h * h;
    const double explicit_gain = 1 + w2;
    const double implicit_gain = 1 / (1 + w2);
    const double rk2_gain = 1 + w2 * w2 / 4;
    const double rk4_gain = 1 - w2 * w2 * w2 / 72 + w2 * w2 * w2 * w2 / 576;
    const auto check = [&](IntegratorKind kind, double gain, long steps) {
        const double energy = spring.energy(run_motion(kind, start, h, steps, spring));
        const double expected = std::exp(static_cast<double>(steps) * std::log1p(gain - 1));
        EXPECT_NEAR(energy / spring.energy(start) / expected, 1.0, 1e-10) << name_of(kind);
    };
    check(IntegratorKind::kExplicitEuler, explicit_gain, 5000);
    check(IntegratorKind::kImplicitEuler, implicit_gain, 5000);
    check(IntegratorKind::kRk2, rk2_gain, 100'000);
    check(IntegratorKind::kRk4, rk4_gain, 100'000);
}

/// Runs forth and back. Each of 2 n steps rounds velocities of up to 6 rad/s by at most 1e-15 (the
/// position form rounds the change h v of a step by the same share). A velocity error changes the
/// swing's period, and so the place by up to 3 x the remaining time x as much. Where all roundings
/// agree this gives 2 n x n h x 3 x 1e-15 / 2.
constexpr long kReturnSteps = 10'000;
constexpr double kReturn = 0.01 * kReturnSteps * kReturnSteps * 3 * 1e-15;

TEST(VelocityVerlet, RunsBackToWhereItStarted) {
    const Pendulum pendulum;
    const auto return_error = [&](IntegratorKind kind) {
        const MotionState<Line> start{Line(2.0), Line(0.3)};
        MotionState<Line> s = run_motion(kind, start, 0.01, kReturnSteps, pendulum);
        EXPECT_GT(apart(s, start), 0.1);
        s.v = -s.v;
        s = run_motion(kind, s, 0.01, kReturnSteps, pendulum);
        s.v = -s.v;
        return apart(s, start);
    };
    EXPECT_LT(return_error(IntegratorKind::kVelocityVerlet), kReturn);
    // The check itself: methods that are not symmetric do not come back.
    EXPECT_GT(return_error(IntegratorKind::kSemiImplicitEuler), 1e-4);
    EXPECT_GT(return_error(IntegratorKind::kRk4), 1e-8);
}

TEST(Verlet, RunsBackToItsFirstTwoPositions) {
    const Pendulum pendulum;
    constexpr double kH = 0.01;
    const Line first(2.0);
    const Line second(1.9987);
    Verlet<Line> forth;
    MotionState<Line> s;
    forth.start_from(first, second, kH, s.x, s.v);
    for (long i = 0; i < kReturnSteps; ++i) {
        forth.step(s.x, s.v, 0.0, kH, pendulum);
        if (i == 0) {
            EXPECT_NEAR(s.x[0], second[0], 1e-15);
        }
    }
    Verlet<Line> back;
    back.start_from(Line(s.x + forth.way()), Line(s.x), kH, s.x, s.v);
    for (long i = 0; i < kReturnSteps; ++i) {
        back.step(s.x, s.v, 0.0, kH, pendulum);
    }
    EXPECT_NEAR(s.x[0], second[0], kReturn);
    EXPECT_NEAR(s.x[0] + back.way()[0], first[0], kReturn);
}

TEST(Verlet, HasThePositionsOfVelocityVerlet) {
    const Pendulum pendulum;
    const MotionState<Line> start{Line(2.0), Line(0.3)};
    const auto a = run_motion(IntegratorKind::kVerlet, start, 0.01, 1000, pendulum);
    const auto b = run_motion(IntegratorKind::kVelocityVerlet, start, 0.01, 1000, pendulum);
    EXPECT_LT(apart(a, b), 1e-9);
}

}  // namespace
}  // namespace zoned::physics
