// Projected Jacobi by mass splitting.
#include "server/physics/solver_variants/row_solvers/row_solvers.h"

namespace zoned::physics {

namespace {

/// In (0, 2); long steps, because most modes are far slower than the bound D.
constexpr double kStep = 1.5;

/// The rows of friction, or all others, from the velocities as they are; the changes go to
/// `previous`.
void find_changes(RowSystem& s, bool rubs) {
    std::vector<double>& change = s.scratch.previous;
    change.assign(s.size(), 0.0);
    for (std::size_t i = 0; i < s.size(); ++i) {
        const double d = s.kind_split[i] + s.soft[i];
        if ((s.rub[i] != 0) != rubs || s.role[i] == RowRole::kConeSecond || !(d > 0.0)) {
            continue;
        }
        double x = s.lambda[i] - kStep * s.excess(i) / d;
        if (s.role[i] == RowRole::kConeFirst) {
            double y = s.lambda[i + 1] - kStep * s.excess(i + 1) / d;
            project_on_disc(s.friction_limit(i), x, y);
            change[i + 1] = y - s.lambda[i + 1];
        } else if (s.role[i] == RowRole::kFriction) {
            const double limit = s.friction_limit(i);
            x = std::min(std::max(x, -limit), limit);
        } else {
            x = std::min(std::max(x, s.low[i]), s.high[i]);
        }
        change[i] = x - s.lambda[i];
    }
}

}  // namespace

SolveReport solve_jacobi(RowSystem& system, const IterationLimits& limits) {
    SolveReport report;
    for (int pass = 0;; ++pass) {
        for (const bool rubs : {false, true}) {
            find_changes(system, rubs);
            const std::vector<double>& change = system.scratch.previous;
            for (std::size_t i = 0; i < system.size(); ++i) {
                if (change[i] != 0.0) {
                    system.lambda[i] += change[i];
                    system.push(i, change[i]);
                }
            }
        }
        if (note_pass(system, limits, pass, report)) {
            return report;
        }
    }
}

}  // namespace zoned::physics
