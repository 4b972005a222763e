// The exact solver: pivoting on the dense matrix of each island.
//
// A guess says of each row whether its impulse is free (then w = 0 is an equation) or at a bound.
// Friction that slides hangs on its normal row, lambda_t = mu lambda_n d with a sign or direction d
// that opposes the slip, so that its column is added to the normal row's. The equations are solved;
// rows that contradict the guess change sides all at once (block pivoting). With friction the
// matrix is not symmetric, and many rows at a time are degenerate in a pile: no rule is known to
// end. After a few rounds the best of them is taken as a step, Gauss-Seidel makes the next guess,
// and an island that is not solved after kAttempts of these is counted as unsolved.
//
// Points that say the same thing twice (a box on four) leave the matrix singular, and what they say
// differs by the rounding of their gaps: a share of the diagonal is added, on the change from the
// impulses that stand. That is a step of the proximal point method (R. T. Rockafellar, SIAM J.
// Control 14, 1976), which ends at a solution of the problem itself; the share is large at first,
// where any guess will do, and a fraction of itself after each step that was found.
#include "server/physics/methods/dense_lu.h"
#include "server/physics/methods/residual.h"
#include "server/physics/methods/solvers.h"

#include <cmath>

namespace zoned::physics {

namespace {

/// Rounds of pivoting from one guess, passes that make the next, and how often that is tried.
constexpr int kRounds = 12;
constexpr int kPasses = 8;
constexpr int kAttempts = 24;
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
/// Of the largest impulse: what no row need mind, as rounding over kLeastGive makes it.
constexpr double kSlack = 1.0e-7;
/// Directions of sliding that turn by less than this have settled, rad.
constexpr double kTurn = 1.0e-6;

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

    void assemble();
    /// The share of the diagonal that is added, from here on.
    void set_give(double give);

    [[nodiscard]] double give() const { return give_; }

    /// From the impulses as they stand. False when no solution was found: then the impulses are
    /// what the round with the fewest contradictions says, as far as that lowers the residual.
    bool solve(int& rounds) {
        clear_right();
        guess_states();
        std::size_t fewest = n_ + 1;
        for (int round = 0; round < kRounds; ++round) {
            ++rounds;
            if (!solve_equations()) {
                break;
            }
            const std::size_t wrong = contradictions(false);
            // The last round's directions will do where only they still turn.
            if (wrong == 0 && (turn_slides() < kTurn || round + 1 == kRounds)) {
                accept();
                return true;
            }
            if (wrong < fewest) {
                fewest = wrong;
                t_.best.assign(t_.previous.begin(), t_.previous.end());
            }
            if (wrong > 0) {
                contradictions(true);
                turn_slides();
            }
        }
        if (fewest <= n_) {
            step_towards_best();
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

    /// In `right` w without any impulse, and no impulse is tried yet.
    void clear_right() {
        for (auto* column : {&t_.previous, &t_.direction, &t_.speeds}) {
            column->assign(n_, 0.0);
        }
        t_.states.assign(n_, kFree);
        for (std::size_t i = 0; i < n_; ++i) {
            double w = s_.excess(first_ + i);
            for (std::size_t j = 0; j < n_; ++j) {
                w -= at(i, j) * s_.lambda[first_ + j];
            }
            t_.right[i] = w;  // the matrix has the share of the diagonal: it counts from here on
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

    /// How many rows contradict their states. With `flip` they change sides.
    std::size_t contradictions(bool flip) {
        double largest = 0.0;
        for (std::size_t i = 0; i < n_; ++i) {
            largest = std::max(largest, std::abs(t_.previous[i]));
        }
        const double slack = kSlack * largest;
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < n_; ++i) {
            if (!(diagonal(i) > 0.0) || s_.role[first_ + i] == RowRole::kConeSecond) {
                continue;
            }
            const std::int8_t to = is_friction(i) ? friction_state(i, slack) : state(i, slack);
            if (to != t_.states[i]) {
                ++wrong;
                if (flip) {
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

    /// What is tried, within its bounds to the last bit.
    void project() {
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
    }

    /// Gives the bodies what is tried.
    void hand_out() {
        for (std::size_t i = 0; i < n_; ++i) {
            s_.push(first_ + i, t_.previous[i] - s_.lambda[first_ + i]);
            s_.lambda[first_ + i] = t_.previous[i];
        }
    }

    void accept() {
        project();
        hand_out();
    }

    /// The longest of a few steps from the impulses that stand to the best that was found which
    /// lowers the residual; none where none does.
    void step_towards_best() {
        const RowGroup group{first_, first_ + static_cast<std::uint32_t>(n_)};
        const double before = residual(s_, group);
        t_.speeds.assign(s_.lambda.begin() + first_, s_.lambda.begin() + group.end);
        for (const double share : {1.0, 0.5, 0.25, 0.1, 0.0}) {
            for (std::size_t i = 0; i < n_; ++i) {
                t_.previous[i] = t_.speeds[i] + share * (t_.best[i] - t_.speeds[i]);
            }
            accept();
            if (residual(s_, group) < before) {
                return;
            }
        }
    }

    RowSystem& s_;
    std::uint32_t first_;
    std::size_t n_;
    SolverScratch& t_;
    double give_ = 0.0;
};

void Pivoting::assemble() {
    t_.matrix.resize(n_ * n_);
    t_.factors.resize(n_ * n_);
    t_.right.resize(2 * n_);
    t_.best.resize(n_);
    t_.pivots.resize(n_);
    for (std::size_t i = 0; i < n_; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            at(i, j) = at(j, i) = s_.coupling(first_ + i, first_ + j);
        }
        at(i, i) += s_.soft[first_ + i];
    }
}

void Pivoting::set_give(double give) {
    for (std::size_t i = 0; i < n_; ++i) {
        at(i, i) += (give - give_) * diagonal(i);
    }
    give_ = give;
}

void relax_group(RowSystem& system, const RowGroup& group, int passes) {
    for (int pass = 0; pass < passes; ++pass) {
        for (std::uint32_t i = group.first; i < group.end; ++i) {
            if (system.role[i] != RowRole::kConeSecond) {
                relax_row(system, i, 1.0);
            }
        }
    }
}

/// Passes of Gauss-Seidel say which rows press, slide and stick; the equations of these states are
/// solved, and what contradicts them decides how to go on: pivoting while it leads on, else a step
/// in that direction and more passes (M. Silcowitz, S. Niebe, K. Erleben, "Projected Gauss-Seidel
/// subspace minimization method for interactive rigid body dynamics", GRAPP 2010).
bool solve_island(RowSystem& system, const RowGroup& group, int passes, int& rounds) {
    rounds = 0;
    Pivoting pivoting(system, group);
    pivoting.assemble();
    pivoting.set_give(kFirstGive);
    relax_group(system, group, kPasses);
    double left = residual(system, group);
    for (int attempt = 0; attempt < kAttempts && left > kSolved; ++attempt) {
        const bool solved = pivoting.solve(rounds);
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
