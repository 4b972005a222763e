// The exact solver: pivoting, island by island, along a proximal path.
#include "server/physics/solver_variants/row_solvers/pivoting.h"
#include "server/physics/solver_variants/row_solvers/row_solvers.h"
#include "server/physics/solver_variants/rows/residual.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// Passes that make a guess, how often one is tried, and the rounds of pivoting in all.
constexpr int kPasses = 8;
constexpr int kAttempts = 24;
constexpr int kMostRounds = 40;
/// Rounds of pivoting from one guess; where the residual is good already, it is not worth many.
constexpr int kGuessRounds = 12;
constexpr int kFewRounds = 3;
/// Share of the diagonal that is added: first, after each step that was found, at most and least.
constexpr double kFirstGive = 1.0e-3;
constexpr double kGiveStep = 0.03;
constexpr double kMostGive = 0.1;
constexpr double kLeastGive = 1.0e-10;
/// A residual that needs no further step, m/s; and one with which an island counts as solved when
/// no step is found any more: positions of a metre in floats round gaps by 6e-8 m, and that in a
/// step of 1/60 s is 3.6e-6 m/s.
constexpr double kSolved = 1.0e-9;
constexpr double kGood = 2.0e-6;

void relax_group(RowSystem& system, const RowGroup& group, int passes) {
    for (int pass = 0; pass < passes; ++pass) {
        for (std::uint32_t i = group.first; i < group.end; ++i) {
            if (system.role[i] != RowRole::kConeSecond) {
                relax_row(system, i, 1.0);
            }
        }
    }
}

/// Passes of Gauss-Seidel guess which rows press, slide and stick. The equations of these states
/// are solved, and the rows that contradict them decide how to go on: pivoting while it leads on,
/// else a step in that direction and more passes (M. Silcowitz, S. Niebe, K. Erleben, "Projected
/// Gauss-Seidel subspace minimization method for interactive rigid body dynamics", GRAPP 2010).
bool solve_island(RowSystem& system, const RowGroup& group, int passes, int& rounds) {
    rounds = 0;
    Pivoting pivoting(system, group);
    pivoting.assemble();
    pivoting.set_give(kFirstGive);
    relax_group(system, group, kPasses);
    double left = residual(system, group);
    for (int attempt = 0; attempt < kAttempts && rounds < kMostRounds && left > kSolved;
         ++attempt) {
        const bool solved = pivoting.solve(left > kGood ? kGuessRounds : kFewRounds, rounds);
        left = residual(system, group);
        if (solved) {
            pivoting.set_give(std::max(pivoting.give() * kGiveStep, kLeastGive));
        } else if (left <= kGood) {
            break;
        } else {
            pivoting.set_give(std::min(pivoting.give() / kGiveStep, kMostGive));
            relax_group(system, group, kPasses);
            left = residual(system, group);
        }
    }
    if (left <= kGood) {
        return true;
    }
    relax_group(system, group, passes);
    return false;
}

}  // namespace

SolveReport solve_direct(RowSystem& system, const IterationLimits& limits) {
    SolveReport report;
    for (const RowGroup& group : system.groups) {
        int rounds = limits.iterations;
        if (group.end - group.first > limits.direct_rows) {
            ++report.too_large;
            relax_group(system, group, limits.iterations);
        } else {
            ++(solve_island(system, group, limits.iterations, rounds) ? report.direct
                                                                      : report.unsolved);
        }
        report.iterations = std::max(report.iterations, rounds);
    }
    if (limits.measure || limits.tolerance_mps > 0.0 || !limits.history.empty()) {
        report.residual_mps = residual(system);
        std::fill(limits.history.begin(), limits.history.end(), report.residual_mps);
    }
    return report;
}

}  // namespace zoned::physics
