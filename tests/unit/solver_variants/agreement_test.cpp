// The solvers of a RowSystem against the exact one, and against their theory.
#include "tests/unit/solver_variants/problems.h"

namespace zoned::physics {
namespace {

struct Problem {
    const char* name;
    RowSystem (*build)(FrictionModel, ManifoldMode);
};

const Problem kProblems[] = {{"boxes on the ground", boxes_on_ground},
                             {"wedge", wedge},
                             {"stack of five", stack_of_five}};

constexpr FrictionModel kModels[] = {FrictionModel::kCone,
                                     FrictionModel::kPyramid,
                                     FrictionModel::kWeight};

RowSystem solved_exactly(const RowSystem& problem) {
    RowSystem exact = problem;
    IterationLimits limits;
    limits.measure = true;
    const SolveReport report = solve_direct(exact, limits);
    EXPECT_EQ(report.direct, exact.groups.size());
    EXPECT_LT(report.residual_mps, 1.0e-8);
    return exact;
}

// An error is at most (1 + L) / c times the residual for a problem of Lipschitz constant L and
// monotonicity c (Facchinei and Pang, 2003, proposition 6.3.1). Scaled by its diagonal a system in
// which 24 rows share a body has L <= 24, and the slowest mode of five boxes has c > 1/40: 1000.
constexpr double kErrorPerResidual = 1000.0;

/// Jacobi's passes lower the slow modes by 1.5 c / 24 each, and it is not asked for as much.
double tolerance_of(SolverVariant method) {
    return method == SolverVariant::kJacobi ? 1.0e-5 : 1.0e-9;
}

TEST(RowSolvers, AgreeWithTheExactOneOnSmallSystems) {
    for (const Problem& problem : kProblems) {
        for (const FrictionModel friction : kModels) {
            for (const ManifoldMode manifold : {ManifoldMode::kPoints, ManifoldMode::kDivided}) {
                const RowSystem start = problem.build(friction, manifold);
                const RowSystem exact = solved_exactly(start);
                for (const SolverVariant method : row_methods()) {
                    SCOPED_TRACE(std::string(problem.name) + ", " + name_of(method) +
                                 ", friction " + std::to_string(static_cast<int>(friction)) +
                                 ", manifold " + std::to_string(static_cast<int>(manifold)));
                    RowSystem s = start;
                    IterationLimits limits;
                    limits.iterations = 20000;
                    limits.tolerance_mps = tolerance_of(method);
                    limits.omega = 1.3;
                    const SolveReport report = solve_rows(method, s, limits);
                    EXPECT_LE(report.residual_mps, tolerance_of(method))
                        << report.iterations << " passes";
                    EXPECT_LT(difference(s, exact), kErrorPerResidual * tolerance_of(method));
                }
            }
        }
    }
}

TEST(RowSolvers, KeepEveryBoundAfterASinglePass) {
    for (const SolverVariant method : row_methods()) {
        SCOPED_TRACE(name_of(method));
        RowSystem s = stack_of_five(FrictionModel::kCone, ManifoldMode::kPoints);
        IterationLimits limits;
        limits.iterations = 1;
        solve_rows(method, s, limits);
        for (std::size_t i = 0; i < s.size(); ++i) {
            EXPECT_GE(s.lambda[i], s.low[i]);
            EXPECT_LE(s.lambda[i], s.high[i]);
            if (s.role[i] == RowRole::kConeFirst) {
                // Normal rows are visited before friction: its bounds are those that hold.
                EXPECT_LE(std::hypot(s.lambda[i], s.lambda[i + 1]),
                          s.friction_limit(i) * (1.0 + 1.0e-12));
            }
        }
    }
}

// Velocities are M^-1 J^T lambda more than they were: solvers that change both one by one must not
// let them part.
TEST(RowSolvers, LeaveVelocitiesThatAreThoseOfTheirImpulses) {
    for (const SolverVariant method : row_methods()) {
        SCOPED_TRACE(name_of(method));
        const RowSystem start = heap(FrictionModel::kCone, ManifoldMode::kPoints);
        RowSystem s = start;
        IterationLimits limits;
        limits.iterations = 25;
        solve_rows(method, s, limits);
        RowSystem again = start;
        again.lambda = s.lambda;
        again.apply_guess();
        EXPECT_LT(difference(s, again), 1.0e-10);
    }
}

int passes_to(SolverVariant method, RowSystem s, double residual) {
    IterationLimits limits;
    limits.iterations = 50000;
    limits.tolerance_mps = residual;
    return solve_rows(method, s, limits).iterations;
}

// Gauss-Seidel's error falls by a factor per pass that nears 1 with the square of a stack's height,
// that of conjugate gradients with the height itself.
TEST(ConjugateGradient, NeedsFewerPassesThanGaussSeidelForTheSameResidual) {
    const RowSystem stack = stack_of_five(FrictionModel::kCone, ManifoldMode::kPoints);
    const RowSystem pile = heap(FrictionModel::kCone, ManifoldMode::kPoints);
    EXPECT_LT(2 * passes_to(SolverVariant::kConjugateGradient, stack, 1.0e-6),
              passes_to(SolverVariant::kGaussSeidel, stack, 1.0e-6));
    EXPECT_LT(2 * passes_to(SolverVariant::kConjugateGradient, pile, 1.0e-6),
              passes_to(SolverVariant::kGaussSeidel, pile, 1.0e-6));
}

TEST(GaussSeidel, NeedsFewerPassesThanJacobi) {
    const RowSystem pile = heap(FrictionModel::kCone, ManifoldMode::kPoints);
    EXPECT_LT(passes_to(SolverVariant::kGaussSeidel, pile, 1.0e-4),
              passes_to(SolverVariant::kJacobi, pile, 1.0e-4));
}

/// The quadratic whose minimum within fixed bounds the solution is: half the kinetic energy's
/// change and the bias' work.
double objective(const RowSystem& start, const RowSystem& s) {
    double sum = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) {
        sum += 0.5 * s.lambda[i] * (s.excess(i) + start.excess(i));
    }
    return sum;
}

// With bounds that do not depend on other rows the problem is a convex quadratic program. Jacobi
// with steps of less than twice the bound on its curvature, and Gauss-Seidel with less than twice
// its diagonal, never let it rise.
TEST(RowSolvers, LowerTheObjectiveInEachPassWhereBoundsAreFixed) {
    for (const SolverVariant method :
         {SolverVariant::kJacobi, SolverVariant::kGaussSeidel, SolverVariant::kOverRelaxation}) {
        SCOPED_TRACE(name_of(method));
        const RowSystem start = heap(FrictionModel::kWeight, ManifoldMode::kPoints);
        RowSystem s = start;
        double last = 0.0;
        for (int pass = 0; pass < 60; ++pass) {
            IterationLimits limits;
            limits.iterations = 1;
            limits.omega = 1.9;
            solve_rows(method, s, limits);
            const double now = objective(start, s);
            EXPECT_LE(now, last + 1.0e-12);
            last = now;
        }
        EXPECT_LT(last, 0.0);
    }
}

TEST(RowSolvers, ReportTheResidualAfterEachPass) {
    RowSystem s = stack_of_five(FrictionModel::kCone, ManifoldMode::kPoints);
    std::vector<double> history(40, -1.0);
    IterationLimits limits;
    limits.iterations = 40;
    limits.history = history;
    const SolveReport report = solve_gauss_seidel(s, limits);
    EXPECT_EQ(report.iterations, 40);
    EXPECT_EQ(report.residual_mps, history.back());
    EXPECT_EQ(report.residual_mps, residual(s));
    EXPECT_LT(history.back(), 0.1 * history.front());
}

// Gauss-Seidel depends on the order of its rows, but its limit does not; Jacobi has no order but
// that of its sums. The spread over orders after twenty passes is measured, and must be there for
// the one and be rounding for the other.
TEST(RowOrder, ChangesWhatGaussSeidelLeavesAndNotWhatJacobiDoes) {
    const RowSystem start = stack_of_five(FrictionModel::kCone, ManifoldMode::kPoints);
    const auto spread = [&](SolverVariant method, int passes) {
        double least = INFINITY;
        double most = 0.0;
        for (std::uint32_t seed = 0; seed < 12; ++seed) {
            RowSystem s = start;
            s.finish(seed);
            IterationLimits limits;
            limits.iterations = passes;
            limits.measure = true;
            const double left = solve_rows(method, s, limits).residual_mps;
            least = std::min(least, left);
            most = std::max(most, left);
        }
        RecordProperty("residual_ratio_" + std::to_string(passes), std::to_string(most / least));
        return most / least;
    };
    EXPECT_GT(spread(SolverVariant::kGaussSeidel, 20), 1.2);
    EXPECT_LT(spread(SolverVariant::kJacobi, 20), 1.0 + 1.0e-9);
    const RowSystem exact = solved_exactly(start);
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        RowSystem s = start;
        s.finish(seed);
        IterationLimits limits;
        limits.iterations = 5000;
        solve_gauss_seidel(s, limits);
        EXPECT_LT(difference(s, exact), 1.0e-4);
    }
}

}  // namespace
}  // namespace zoned::physics
