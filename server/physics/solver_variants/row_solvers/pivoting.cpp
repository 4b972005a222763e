#include "server/physics/solver_variants/row_solvers/pivoting.h"

#include "server/physics/solver_variants/row_solvers/dense_lu.h"
#include "server/physics/solver_variants/rows/residual.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// As a share of the largest impulse: no row need heed less, as rounding over kLeastGive makes it.
constexpr double kImpulseSlack = 1.0e-7;
/// Directions of sliding that turn by less than this have settled, rad.
constexpr double kTurn = 1.0e-6;

enum State : std::int8_t {
    kFree,
    kLow,
    kHigh,
    kSlides
};

}  // namespace

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

bool Pivoting::solve(int most, int& rounds) {
    clear_right();
    guess_states();
    std::size_t fewest = n_ + 1;
    for (int round = 0; round < most; ++round) {
        ++rounds;
        if (!solve_equations()) {
            break;
        }
        const std::size_t wrong = contradictions(false);
        // The last round's directions will do where only they still turn.
        if (wrong == 0 && (turn_slides() < kTurn || round + 1 == most)) {
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

void Pivoting::clear_right() {
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

void Pivoting::guess_states() {
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

void Pivoting::guess_cone(std::size_t i, double x) {
    const std::size_t row = first_ + i;
    const double y = s_.lambda[row + 1] - s_.excess(row + 1) / diagonal(i);
    const double limit = s_.friction_limit(row);
    const double size = std::sqrt(x * x + y * y);
    if (limit > 0.0 && size > limit) {
        slide_along(i, x / size, y / size);
    }
}

void Pivoting::slide_along(std::size_t i, double x, double y) {
    t_.states[i] = t_.states[i + 1] = kSlides;
    t_.direction[i] = x;
    t_.direction[i + 1] = y;
}

void Pivoting::set_states(std::size_t i, std::int8_t state) {
    t_.states[i] = state;
    if (s_.role[first_ + i] == RowRole::kConeFirst) {
        t_.states[i + 1] = state;
    }
}

double Pivoting::bound_of(std::size_t i) const {
    const double d = diagonal(i);
    if (!(d > 0.0) || is_friction(i)) {
        return 0.0;
    }
    return t_.states[i] == kLow ? s_.low[first_ + i] : s_.high[first_ + i];
}

bool Pivoting::solve_equations() {
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
            t_.previous[i] = s_.friction[first_ + i] * t_.previous[normal_of(i)] * t_.direction[i];
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

void Pivoting::fill_factors(std::size_t u) {
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

std::size_t Pivoting::contradictions(bool flip) {
    double largest = 0.0;
    for (std::size_t i = 0; i < n_; ++i) {
        largest = std::max(largest, std::abs(t_.previous[i]));
    }
    const double slack = kImpulseSlack * largest;
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

std::int8_t Pivoting::state(std::size_t i, double slack) const {
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

std::int8_t Pivoting::friction_state(std::size_t i, double slack) const {
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

void Pivoting::flip_to(std::size_t i, std::int8_t to) {
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

double Pivoting::turn_slides() {
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

void Pivoting::project() {
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

void Pivoting::hand_out() {
    for (std::size_t i = 0; i < n_; ++i) {
        s_.push(first_ + i, t_.previous[i] - s_.lambda[first_ + i]);
        s_.lambda[first_ + i] = t_.previous[i];
    }
}

void Pivoting::accept() {
    project();
    hand_out();
}

void Pivoting::step_towards_best() {
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

}  // namespace zoned::physics
