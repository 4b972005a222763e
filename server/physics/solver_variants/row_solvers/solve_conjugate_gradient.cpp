// Nonsmooth nonlinear conjugate gradient.
#include "server/physics/solver_variants/row_solvers/row_solvers.h"

namespace zoned::physics {

namespace {

/// |last pass's change|^2 in the metric of the diagonal. `previous` holds lambda before it.
double squared_change(const RowSystem& s) {
    double sum = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) {
        const double change = s.lambda[i] - s.scratch.previous[i];
        sum += (s.response[i] + s.soft[i]) * change * change;
    }
    return sum;
}

/// lambda += beta p, and p <- beta p + change. Bounds are kept by the pass that follows.
void follow_direction(RowSystem& s, double beta) {
    for (std::size_t i = 0; i < s.size(); ++i) {
        const double change = s.lambda[i] - s.scratch.previous[i];
        const double along = beta * s.scratch.direction[i];
        if (along != 0.0) {
            s.lambda[i] += along;
            s.push(i, along);
        }
        s.scratch.direction[i] = along + change;
    }
}

}  // namespace

SolveReport solve_conjugate_gradient(RowSystem& system, const IterationLimits& limits) {
    SolveReport report;
    std::vector<double>& previous = system.scratch.previous;
    std::vector<double>& direction = system.scratch.direction;
    direction.assign(system.size(), 0.0);
    double last = 0.0;
    for (int pass = 0;; ++pass) {
        previous.assign(system.lambda.begin(), system.lambda.end());
        relax_all(system, 1.0);
        if (note_pass(system, limits, pass, report)) {
            return report;
        }
        const double now = squared_change(system);
        const double beta = last > 0.0 ? now / last : 0.0;
        // Where the gradient grows, the direction has led astray: start anew from the gradient.
        follow_direction(system, beta <= 1.0 ? beta : 0.0);
        if (beta > 1.0) {
            direction.assign(system.size(), 0.0);
        }
        last = now;
    }
}

}  // namespace zoned::physics
