// The solvers of a RowSystem: one signature, one file each.
#pragma once

#include "server/physics/settings/variant_settings.h"
#include "server/physics/solver_variants/rows/row_system.h"

#include <cstdint>
#include <span>

namespace zoned::compute {
class Team;
}

namespace zoned::physics {

/// How long a solver may go on. Passes are counted, never timed.
struct IterationLimits {
    int iterations = 20;              ///< passes over all rows, > 0
    double tolerance_mps = 0.0;       ///< end when the residual is no greater; 0: never looked at
    double omega = 1.0;               ///< over relaxation alone
    std::uint32_t direct_rows = 400;  ///< direct alone: islands with more are left to Gauss-Seidel
    bool measure = false;             ///< report the residual at the end
    std::span<double> history;        ///< the residual after each pass, as far as there is room
    compute::Team* team = nullptr;    ///< Jacobi alone: its threads help; null: nobody does
};

struct SolveReport {
    int iterations = 0;           ///< passes done; direct: rounds of pivoting of the longest
    double residual_mps = 0.0;    ///< see residual.h; 0 unless a setting asked for it
    std::uint32_t direct = 0;     ///< islands solved exactly
    std::uint32_t too_large = 0;  ///< islands with more rows than `direct_rows`
    std::uint32_t unsolved = 0;   ///< islands where pivoting found no end
};

/// All start from `lambda`, which the bodies' velocities hold already. They end with bounds kept
/// and velocities that hold the new `lambda`.

/// Projected Jacobi by mass splitting. First all rows that are not friction step at once, then all
/// friction rows: lambda <- P(lambda - 1.5 w / D), each with its share of the bodies' masses. J
/// M^-1 J^T <= D holds for the rows of one kind (row_system.cpp). So each step of less than twice w
/// / D lowers the energy norm of the error of a system with fixed bounds. It converges, where the
/// plain method does not (R. Tonge et al., ACM TOG 31, 2012). Rows find their steps on several
/// threads, then bodies add up theirs in the order of rows: the result has the same bits for any
/// number of threads.
SolveReport solve_jacobi(RowSystem& system, const IterationLimits& limits);

/// Projected Gauss-Seidel: one row after the other (C. Cryer, SIAM J. Control 9, 1971; the
/// "sequential impulses" of games). The two rows of a cone are projected together.
SolveReport solve_gauss_seidel(RowSystem& system, const IterationLimits& limits);

/// The same with steps of `omega`, in (0, 2) for convergence with fixed bounds (C. Cryer, 1971).
SolveReport solve_over_relaxation(RowSystem& system, const IterationLimits& limits);

/// Nonsmooth nonlinear conjugate gradient: the change by a pass of Gauss-Seidel is taken for a
/// gradient, combined by Fletcher and Reeves' rule. The direction is dropped where the gradient
/// grows (M. Silcowitz, S. Niebe, K. Erleben, "A nonsmooth nonlinear conjugate gradient method for
/// interactive contact force problems", The Visual Computer 26, 2010). Norms are taken in the
/// metric of the diagonal, so that impulses and moments have one unit.
SolveReport solve_conjugate_gradient(RowSystem& system, const IterationLimits& limits);

/// Exact to rounding: block principal pivoting (J. Judice, F. Pires, Computers & Operations
/// Research 21, 1994) on the dense matrix of each island, with friction's bounds as equations on
/// the rows that slide (P. Alart, A. Curnier, Comp. Meth. Appl. Mech. Eng. 92, 1991). See
/// solve_direct.cpp.
SolveReport solve_direct(RowSystem& system, const IterationLimits& limits);

/// The solver of a method; only for those that solve a RowSystem.
SolveReport solve_rows(SolverVariant method, RowSystem& system, const IterationLimits& limits);

/// The parts that the solvers share.
/// One row takes `step` times the step to where its w is zero, within its bounds.
void relax_row(RowSystem& system, std::uint32_t row, double step);
/// One pass of Gauss-Seidel over all rows.
void relax_all(RowSystem& system, double step);
/// Notes the residual after pass `pass`, 0-based; true when the solver may end.
bool note_pass(const RowSystem& system,
               const IterationLimits& limits,
               int pass,
               SolveReport& report);

}  // namespace zoned::physics
