// Projected Jacobi by mass splitting.
#include "server/physics/methods/solvers.h"

namespace zoned::physics {

namespace {

/// All rows from the velocities of the last pass; what changed goes to `previous`.
void step_all(RowSystem& s) {
    std::vector<double>& change = s.scratch.previous;
    change.assign(s.size(), 0.0);
    // Normal rows first: friction's bounds are those of the normal impulses that this pass gives.
    for (std::size_t i = 0; i < s.size(); ++i) {
        const double d = s.split[i] + s.soft[i];
        if ((s.role[i] == RowRole::kBounded || s.role[i] == RowRole::kNormal) && d > 0.0) {
            const double to =
                std::min(std::max(s.lambda[i] - s.excess(i) / d, s.low[i]), s.high[i]);
            change[i] = to - s.lambda[i];
        }
    }
    for (std::size_t i = 0; i < s.size(); ++i) {
        const double d = s.split[i] + s.soft[i];
        if (s.role[i] == RowRole::kBounded || s.role[i] == RowRole::kNormal ||
            s.role[i] == RowRole::kConeSecond || !(d > 0.0)) {
            continue;
        }
        const double load = s.lambda[s.normal[i]] + change[s.normal[i]];
        const double limit = s.friction[i] * std::max(load, 0.0);
        double x = s.lambda[i] - s.excess(i) / d;
        if (s.role[i] == RowRole::kFriction) {
            change[i] = std::min(std::max(x, -limit), limit) - s.lambda[i];
        } else {
            double y = s.lambda[i + 1] - s.excess(i + 1) / d;
            project_on_disc(limit, x, y);
            change[i] = x - s.lambda[i];
            change[i + 1] = y - s.lambda[i + 1];
        }
    }
}

}  // namespace

SolveReport solve_jacobi(RowSystem& system, const IterationLimits& limits) {
    SolveReport report;
    for (int pass = 0;; ++pass) {
        step_all(system);
        const std::vector<double>& change = system.scratch.previous;
        for (std::size_t i = 0; i < system.size(); ++i) {
            if (change[i] != 0.0) {
                system.lambda[i] += change[i];
                system.push(i, change[i]);
            }
        }
        if (note_pass(system, limits, pass, report)) {
            return report;
        }
    }
}

}  // namespace zoned::physics
