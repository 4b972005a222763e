// Projected Jacobi by mass splitting.
#include "server/compute/team.h"
#include "server/physics/solver_variants/row_solvers/row_solvers.h"

namespace zoned::physics {

namespace {

/// In (0, 2); long steps, because most modes are far slower than the bound D.
constexpr double kStep = 1.5;
/// Rows and bodies of one piece of work: some ten microseconds.
constexpr std::size_t kRowGrain = 256;
constexpr std::size_t kBodyGrain = 64;

/// Lists the rows of each body that moves, ascending: a counting sort.
void list_rows_of_bodies(RowSystem& s) {
    std::vector<std::uint32_t>& first = s.scratch.first_of_body;
    first.assign(s.bodies.size() + 1, 0);
    for (std::size_t i = 0; i < s.size(); ++i) {
        ++first[s.a[i] + 1];
        ++first[s.b[i] + 1];
    }
    first[1] = 0;  // what does not move needs no list
    for (std::size_t body = 1; body < first.size(); ++body) {
        first[body] += first[body - 1];
    }
    s.scratch.row_and_side.resize(first.back());
    for (std::size_t i = 0; i < s.size(); ++i) {
        for (const std::uint32_t side : {0U, 1U}) {
            const std::uint32_t body = side == 0 ? s.a[i] : s.b[i];
            if (body != 0) {
                s.scratch.row_and_side[first[body]++] = static_cast<std::uint32_t>(2 * i) + side;
            }
        }
    }
    std::copy_backward(first.begin(), first.end() - 1, first.end());
    first[0] = 0;
}

/// Gives bodies from `begin` to `end` the changes of their rows.
void add_changes(RowSystem& s, std::size_t begin, std::size_t end) {
    const std::vector<double>& change = s.scratch.previous;
    for (std::size_t body = begin; body < end; ++body) {
        for (std::size_t k = s.scratch.first_of_body[body]; k < s.scratch.first_of_body[body + 1];
             ++k) {
            const std::uint32_t row = s.scratch.row_and_side[k] / 2;
            if (change[row] == 0.0) {
                continue;
            }
            if (s.scratch.row_and_side[k] % 2 == 0) {
                s.push_first(row, change[row]);
            } else {
                s.push_second(row, change[row]);
            }
        }
    }
}

/// The rows of friction, or all others, from the velocities as they are; the changes go to
/// `previous`. A cone's second row is changed with its first.
void find_changes(RowSystem& s, bool rubs, std::size_t begin, std::size_t end) {
    std::vector<double>& change = s.scratch.previous;
    for (std::size_t i = begin; i < end; ++i) {
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
    compute::Team alone;
    compute::Team& team = limits.team != nullptr ? *limits.team : alone;
    std::vector<double>& change = system.scratch.previous;
    list_rows_of_bodies(system);
    SolveReport report;
    for (int pass = 0;; ++pass) {
        for (const bool rubs : {false, true}) {
            change.assign(system.size(), 0.0);
            team.run(system.size(), kRowGrain, [&](std::size_t begin, std::size_t end) {
                find_changes(system, rubs, begin, end);
            });
            team.run(system.bodies.size(), kBodyGrain, [&](std::size_t begin, std::size_t end) {
                add_changes(system, begin, end);
            });
            for (std::size_t i = 0; i < system.size(); ++i) {
                if (change[i] != 0.0) {
                    system.lambda[i] += change[i];
                }
            }
        }
        if (note_pass(system, limits, pass, report)) {
            return report;
        }
    }
}

}  // namespace zoned::physics
