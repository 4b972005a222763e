// Projected Gauss-Seidel, and the code that its relatives share with it.
#include "server/physics/solver_variants/row_solvers/row_solvers.h"
#include "server/physics/solver_variants/rows/residual.h"

namespace zoned::physics {

namespace {

void relax_cone(RowSystem& s, std::uint32_t i, double step) {
    const double d = s.response[i] + s.soft[i];
    if (!(d > 0.0)) {
        return;
    }
    const double before1 = s.lambda[i];
    const double before2 = s.lambda[i + 1];
    double x = before1 - step * s.excess(i) / d;
    double y = before2 - step * s.excess(i + 1) / d;
    project_on_disc(s.friction_limit(i), x, y);
    s.lambda[i] = x;
    s.lambda[i + 1] = y;
    s.push(i, x - before1);
    s.push(i + 1, y - before2);
}

}  // namespace

void relax_row(RowSystem& s, std::uint32_t i, double step) {
    if (s.role[i] == RowRole::kConeFirst) {
        relax_cone(s, i, step);
        return;
    }
    const double d = s.response[i] + s.soft[i];
    if (!(d > 0.0)) {
        return;
    }
    double low = s.low[i];
    double high = s.high[i];
    if (s.role[i] == RowRole::kFriction) {
        high = s.friction_limit(i);
        low = -high;
    }
    const double before = s.lambda[i];
    const double after = std::min(std::max(before - step * s.excess(i) / d, low), high);
    s.lambda[i] = after;
    s.push(i, after - before);
}

void relax_all(RowSystem& system, double step) {
    for (const std::uint32_t row : system.order) {
        relax_row(system, row, step);
    }
}

bool note_pass(const RowSystem& system,
               const IterationLimits& limits,
               int pass,
               SolveReport& report) {
    report.iterations = pass + 1;
    const bool last = pass + 1 == limits.iterations;
    const bool room = static_cast<std::size_t>(pass) < limits.history.size();
    if (room || limits.tolerance_mps > 0.0 || (last && limits.measure)) {
        report.residual_mps = residual(system);
    }
    if (room) {
        limits.history[static_cast<std::size_t>(pass)] = report.residual_mps;
    }
    return last || (limits.tolerance_mps > 0.0 && report.residual_mps <= limits.tolerance_mps);
}

SolveReport solve_gauss_seidel(RowSystem& system, const IterationLimits& limits) {
    SolveReport report;
    for (int pass = 0;; ++pass) {
        relax_all(system, 1.0);
        if (note_pass(system, limits, pass, report)) {
            return report;
        }
    }
}

SolveReport solve_rows(SolverVariant method, RowSystem& system, const IterationLimits& limits) {
    switch (method) {
        case SolverVariant::kJacobi:
            return solve_jacobi(system, limits);
        case SolverVariant::kOverRelaxation:
            return solve_over_relaxation(system, limits);
        case SolverVariant::kConjugateGradient:
            return solve_conjugate_gradient(system, limits);
        case SolverVariant::kDirect:
            return solve_direct(system, limits);
        default:
            return solve_gauss_seidel(system, limits);
    }
}

}  // namespace zoned::physics
