// Projected successive over relaxation.
#include "server/physics/solver_variants/row_solvers/row_solvers.h"

namespace zoned::physics {

SolveReport solve_over_relaxation(RowSystem& system, const IterationLimits& limits) {
    SolveReport report;
    for (int pass = 0;; ++pass) {
        relax_all(system, limits.omega);
        if (note_pass(system, limits, pass, report)) {
            return report;
        }
    }
}

}  // namespace zoned::physics
