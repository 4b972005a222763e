// The exact solver: pivoting on the dense matrix of each island.
//
// A guess says of each row whether its impulse is free (then w = 0 is an equation) or at a bound.
// Friction that slides hangs on its normal row, lambda_t = mu lambda_n d with a sign or direction d
// that opposes the slip, so that its column is added to the normal row's. The equations are solved;
// rows that contradict the guess change sides, all at once while that lowers their number (block
// pivoting), else the last one alone (Murty's rule, which ends for positive definite matrices).
// With friction the matrix is not symmetric and no rule is known to end: after kMostRounds the
// guess is made better by Gauss-Seidel and pivoting tried again; when that has failed too often the
// island counts as unsolved.
//
// Points that say the same thing twice (a box on four) leave the matrix singular: a share of the
// diagonal is added, on the change from the first guess, so that the load is spread evenly about
// the guess and what that costs in accuracy is gone once the guess is right.
#include "server/physics/methods/dense_lu.h"
#include "server/physics/methods/residual.h"
#include "server/physics/methods/solvers.h"

#include <cmath>

namespace zoned::physics {

namespace {

constexpr int kMostRounds = 30;
/// Rounds in a row that may fail to lower the number of contradictions.
constexpr int kPatience = 4;
/// Share of the diagonal that is added, and of the largest impulse that no row need mind. The first
/// leaves |w| = 1e-10 d |change|; the second is what that makes of rounding, 1e-16 / 1e-10, and a
/// digit more.
constexpr double kGive = 1.0e-10;
constexpr double kSlack = 1.0e-7;
/// Directions of sliding that turn by less than this have settled, rad.
constexpr double kTurn = 1.0e-8;

enum State : std::int8_t {
    kFree,
    kLow,
    kHigh,
    kSlides
};

class Pivoting {
  public:
    Pivoting(RowSystem& system, const RowGroup& group)
        : s_(system),
          first_(group.first),
          n_(group.end - group.first),
          t_(system.scratch) {}

    /// False when no solution was found: then nothing has changed.
    bool solve(int& rounds) {
        assemble();
        guess_states();
        std::size_t fewest = n_ + 1;
        int patience = kPatience;
        for (rounds = 1; rounds <= kMostRounds; ++rounds) {
            if (!solve_equations()) {
                return false;
            }
            const std::size_t wrong = contradictions(false, n_);
            if (getenv("TR"))
                printf("round %d wrong %zu of %u\n", rounds, wrong, (unsigned)n_);
            if (wrong == 0) {
                if (turn_slides() < kTurn) {
                    accept();
                    return true;
                }
                fewest = n_ + 1;
                continue;
            }
            if (wrong < fewest) {
                fewest = wrong;
                patience = kPatience;
            } else {
                --patience;
            }
            contradictions(true, patience >= 0 ? n_ : 1);
            turn_slides();
        }
        return false;
    }

  private:
    [[nodiscard]] double& at(std::size_t i, std::size_t j) { return t_.matrix[i * n_ + j]; }

    [[nodiscard]] double diagonal(std::size_t i) const {
        return s_.response[first_ + i] + s_.soft[first_ + i];
    }

    [[nodiscard]] bool is_friction(std::size_t i) const {
        return s_.role[first_ + i] != RowRole::kBounded && s_.role[first_ + i] != RowRole::kNormal;
    }

    [[nodiscard]] std::size_t normal_of(std::size_t i) const {
        return s_.normal[first_ + i] - first_;
    }

    /// Of the impulses that are being tried, N s.
    [[nodiscard]] double limit_of(std::size_t i) const {
        return s_.friction[first_ + i] * std::max(t_.previous[normal_of(i)], 0.0);
    }

    /// The matrix, and in `right` w without any impulse.
    void assemble() {
        t_.matrix.resize(n_ * n_);
        t_.factors.resize(n_ * n_);
        t_.right.resize(2 * n_);
        for (auto* column : {&t_.previous, &t_.direction, &t_.speeds}) {
            column->assign(n_, 0.0);
        }
        t_.states.assign(n_, kFree);
        t_.pivots.resize(n_);
        for (std::size_t i = 0; i < n_; ++i) {
            for (std::size_t j = 0; j <= i; ++j) {
                at(i, j) = at(j, i) = s_.coupling(first_ + i, first_ + j);
            }
            at(i, i) += s_.soft[first_ + i];
        }
        for (std::size_t i = 0; i < n_; ++i) {
            double w = s_.excess(first_ + i);
            for (std::size_t j = 0; j < n_; ++j) {
                w -= at(i, j) * s_.lambda[first_ + j];
            }
            const double give = kGive * diagonal(i);
            t_.right[i] = w - give * s_.lambda[first_ + i];
        }
        for (std::size_t i = 0; i < n_; ++i) {
            at(i, i) += kGive * diagonal(i);
        }
    }

    /// By where a step of the natural map would go from the first guess.
    void guess_states() {
        for (std::size_t i = 0; i < n_; ++i) {
            const std::size_t row = first_ + i;
            const double d = diagonal(i);
            const double to = d > 0.0 ? s_.lambda[row] - s_.excess(row) / d : 0.0;
            if (!(d > 0.0)) {
                t_.states[i] = kLow;  // nothing moves it
            } else if (!is_friction(i)) {
                t_.states[i] = to <= s_.low[row] ? kLow : to >= s_.high[row] ? kHigh : kFree;
            } else if (s_.role[row] == RowRole::kFriction) {
                const double limit = s_.friction_limit(row);
                const bool slides = limit > 0.0 && std::abs(to) > limit;
                t_.states[i] = slides ? kSlides : kFree;
                t_.direction[i] = to < 0.0 ? -1.0 : 1.0;
            } else if (s_.role[row] == RowRole::kConeFirst) {
                guess_cone(i, to);
            }
        }
    }

    void guess_cone(std::size_t i, double x) {
        const std::size_t row = first_ + i;
        const double y = s_.lambda[row + 1] - s_.excess(row + 1) / diagonal(i);
        const double limit = s_.friction_limit(row);
        const double size = std::sqrt(x * x + y * y);
        if (limit > 0.0 && size > limit) {
            slide_along(i, x / size, y / size);
        }
    }

    void slide_along(std::size_t i, double x, double y) {
        t_.states[i] = t_.states[i + 1] = kSlides;
        t_.direction[i] = x;
        t_.direction[i + 1] = y;
    }

    void set_states(std::size_t i, std::int8_t state) {
        t_.states[i] = state;
        if (s_.role[first_ + i] == RowRole::kConeFirst) {
            t_.states[i + 1] = state;
        }
    }

    [[nodiscard]] double bound_of(std::size_t i) const {
        const double d = diagonal(i);
        if (!(d > 0.0) || is_friction(i)) {
            return 0.0;
        }
        return t_.states[i] == kLow ? s_.low[first_ + i] : s_.high[first_ + i];
    }

    /// All impulses, and w where they are not free, from the states.
    bool solve_equations() {
        t_.unknowns.clear();
        for (std::uint32_t i = 0; i < n_; ++i) {
            if (t_.states[i] == kFree) {
                t_.unknowns.push_back(i);
            }
        }
        const std::size_t u = t_.unknowns.size();
        const std::span<double> x(t_.right.data() + n_, u);
        for (std::size_t r = 0; r < u; ++r) {
            const std::size_t i = t_.unknowns[r];
            double sum = -t_.right[i];
            for (std::size_t j = 0; j < n_; ++j) {
                if (t_.states[j] == kLow || t_.states[j] == kHigh) {
                    sum -= at(i, j) * bound_of(j);
                }
            }
            x[r] = sum;
        }
        fill_factors(u);
        if (!factor_dense(u, std::span(t_.factors).first(u * u), t_.pivots)) {
            return false;
        }
        solve_dense(u, t_.factors, t_.pivots, x);
        for (std::size_t i = 0; i < n_; ++i) {
            t_.previous[i] = t_.states[i] == kLow || t_.states[i] == kHigh ? bound_of(i) : 0.0;
        }
        for (std::size_t r = 0; r < u; ++r) {
            t_.previous[t_.unknowns[r]] = x[r];
        }
        for (std::size_t i = 0; i < n_; ++i) {
            if (t_.states[i] == kSlides) {
                t_.previous[i] =
                    s_.friction[first_ + i] * t_.previous[normal_of(i)] * t_.direction[i];
            }
        }
        for (std::size_t i = 0; i < n_; ++i) {
            double w = 0.0;
            for (std::size_t j = 0; t_.states[i] != kFree && j < n_; ++j) {
                w += at(i, j) * t_.previous[j];
            }
            t_.speeds[i] = t_.states[i] == kFree ? 0.0 : w + t_.right[i];
        }
        return true;
    }

    /// Columns of free rows, those of what slides added to their normal rows'.
    void fill_factors(std::size_t u) {
        for (std::size_t r = 0; r < u; ++r) {
            const double* from = &t_.matrix[t_.unknowns[r] * n_];
            t_.speeds.assign(from, from + n_);
            for (std::size_t j = 0; j < n_; ++j) {
                if (t_.states[j] == kSlides) {
                    t_.speeds[normal_of(j)] += s_.friction[first_ + j] * t_.direction[j] * from[j];
                }
            }
            for (std::size_t c = 0; c < u; ++c) {
                t_.factors[r * u + c] = t_.speeds[t_.unknowns[c]];
            }
        }
    }

    /// How many rows contradict their states. With `flip`, up to `most` of them change sides, the
    /// last ones first.
    std::size_t contradictions(bool flip, std::size_t most) {
        double largest = 0.0;
        for (std::size_t i = 0; i < n_; ++i) {
            largest = std::max(largest, std::abs(t_.previous[i]));
        }
        const double slack = kSlack * largest;
        std::size_t wrong = 0;
        for (std::size_t i = n_; i-- > 0;) {
            if (!(diagonal(i) > 0.0) || s_.role[first_ + i] == RowRole::kConeSecond) {
                continue;
            }
            const std::int8_t to = is_friction(i) ? friction_state(i, slack) : state(i, slack);
            if (to != t_.states[i]) {
                ++wrong;
                if (flip && wrong <= most) {
                    flip_to(i, to);
                }
            }
        }
        return wrong;
    }

    [[nodiscard]] std::int8_t state(std::size_t i, double slack) const {
        const std::size_t row = first_ + i;
        const double x = t_.previous[i];
        const double w = t_.speeds[i];
        const double still = slack * diagonal(i);
        const bool pinned = s_.low[row] == s_.high[row];
        switch (t_.states[i]) {
            case kFree:
                return x < s_.low[row] - slack ? kLow : x > s_.high[row] + slack ? kHigh : kFree;
            case kLow:
                return w < -still && !pinned ? kFree : kLow;
            default:
                return w > still && !pinned ? kFree : kHigh;
        }
    }

    [[nodiscard]] std::int8_t friction_state(std::size_t i, double slack) const {
        const double limit = limit_of(i);
        const bool cone = s_.role[first_ + i] == RowRole::kConeFirst;
        const double d = diagonal(i);
        const double x = t_.previous[i] - t_.speeds[i] / d;
        const double y = cone ? t_.previous[i + 1] - t_.speeds[i + 1] / d : 0.0;
        const double size = std::sqrt(x * x + y * y);
        if (t_.states[i] == kFree) {
            return size > limit + slack ? kSlides : kFree;
        }
        if (limit <= 0.0) {
            return kSlides;  // by nothing: its direction does not matter
        }
        const double along = cone ? size : x * t_.direction[i];
        return along < limit - slack ? kFree : kSlides;
    }

    void flip_to(std::size_t i, std::int8_t to) {
        if (to == kSlides) {
            const double x = t_.previous[i];
            if (s_.role[first_ + i] == RowRole::kConeFirst) {
                const double y = t_.previous[i + 1];
                const double size = std::sqrt(x * x + y * y);
                slide_along(i, x / size, y / size);
                return;
            }
            t_.direction[i] = x < 0.0 ? -1.0 : 1.0;
        }
        set_states(i, to);
    }

    /// Directions of sliding cones against the slip that came out; the largest turn.
    double turn_slides() {
        double largest = 0.0;
        for (std::size_t i = 0; i + 1 < n_; ++i) {
            if (s_.role[first_ + i] != RowRole::kConeFirst || t_.states[i] != kSlides ||
                !(limit_of(i) > 0.0)) {
                continue;
            }
            const double d = diagonal(i);
            const double x = t_.previous[i] - t_.speeds[i] / d;
            const double y = t_.previous[i + 1] - t_.speeds[i + 1] / d;
            const double size = std::sqrt(x * x + y * y);
            if (size > 0.0) {
                const double turn =
                    std::abs(x / size - t_.direction[i]) + std::abs(y / size - t_.direction[i + 1]);
                largest = std::max(largest, turn);
                slide_along(i, x / size, y / size);
            }
        }
        return largest;
    }

    /// Gives the bodies what was found, within its bounds to the last bit.
    void accept() {
        for (std::size_t i = 0; i < n_; ++i) {
            const std::size_t row = first_ + i;
            if (!is_friction(i)) {
                t_.previous[i] = std::min(std::max(t_.previous[i], s_.low[row]), s_.high[row]);
            }
        }
        for (std::size_t i = 0; i < n_; ++i) {
            const std::size_t row = first_ + i;
            if (s_.role[row] == RowRole::kFriction) {
                const double limit = limit_of(i);
                t_.previous[i] = std::min(std::max(t_.previous[i], -limit), limit);
            } else if (s_.role[row] == RowRole::kConeFirst) {
                project_on_disc(limit_of(i), t_.previous[i], t_.previous[i + 1]);
            }
        }
        for (std::size_t i = 0; i < n_; ++i) {
            s_.push(first_ + i, t_.previous[i] - s_.lambda[first_ + i]);
            s_.lambda[first_ + i] = t_.previous[i];
        }
    }

    RowSystem& s_;
    std::uint32_t first_;
    std::size_t n_;
    SolverScratch& t_;
};

void relax_group(RowSystem& system, const RowGroup& group, int passes) {
    for (int pass = 0; pass < passes; ++pass) {
        for (std::uint32_t i = group.first; i < group.end; ++i) {
            if (system.role[i] != RowRole::kConeSecond) {
                relax_row(system, i, 1.0);
            }
        }
    }
}

/// A guess by a few passes, then pivoting; from a better guess where that fails. The passes after
/// the last failure stand in for the solution.
bool solve_island(RowSystem& system, const RowGroup& group, int passes, int& rounds) {
    int spent = 0;
    bool solved = false;
    for (const int first_passes : {8, 32, 128}) {
        relax_group(system, group, first_passes);
        int tried = 0;
        solved = Pivoting(system, group).solve(tried);
        spent += tried;
        if (solved) {
            break;
        }
    }
    if (!solved) {
        relax_group(system, group, passes);
    }
    rounds = spent;
    return solved;
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
