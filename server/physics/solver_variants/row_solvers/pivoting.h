// Pivoting: decides which rows of an island press, slide or stick, and solves their equations.
#pragma once

#include "server/physics/solver_variants/rows/row_system.h"

#include <cstdint>

namespace zoned::physics {

/// A guess says of each row whether its impulse is free (then w = 0 is an equation) or at a bound.
/// Friction that slides hangs on its normal row, lambda_t = mu lambda_n d with a sign or direction
/// d that opposes the slip, so that its column is added to the normal row's. The equations are
/// solved; rows that contradict the guess change sides all at once (block pivoting). With friction
/// the matrix is not symmetric, and many rows at a time are degenerate in a pile: no rule is known
/// to end. After a few rounds the best of them is taken as a step, and Gauss-Seidel makes the next
/// guess. An island that is not solved after some of these is counted as unsolved.
///
/// Redundant points (a box on four) leave the matrix singular, and their rows differ by the
/// rounding of their gaps. So a share of the diagonal is added, on the change from the impulses
/// that stand. That is a step of the proximal point method (R. T. Rockafellar, SIAM J. Control 14,
/// 1976), which ends at a solution of the problem itself. The share is large at first, where any
/// guess will do, and a fraction of itself after each step that was found.
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

    /// From the impulses as they stand, in up to `most` rounds, which are added to `rounds`. False
    /// when no solution was found. Then the impulses are those of the round with the fewest
    /// contradictions, as far as that lowers the residual.
    bool solve(int most, int& rounds);

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
    void clear_right();

    /// By where a step of the natural map would go from the first guess.
    void guess_states();

    void guess_cone(std::size_t i, double x);

    void slide_along(std::size_t i, double x, double y);

    void set_states(std::size_t i, std::int8_t state);

    [[nodiscard]] double bound_of(std::size_t i) const;

    /// All impulses, and w where they are not free, from the states.
    bool solve_equations();

    /// Columns of free rows; those of sliding rows are added to their normal rows'.
    void fill_factors(std::size_t u);

    /// How many rows contradict their states. With `flip` they change sides.
    std::size_t contradictions(bool flip);

    [[nodiscard]] std::int8_t state(std::size_t i, double slack) const;

    [[nodiscard]] std::int8_t friction_state(std::size_t i, double slack) const;

    void flip_to(std::size_t i, std::int8_t to);

    /// Directions of sliding cones against the slip that came out; the largest turn.
    double turn_slides();

    /// The impulse to try, within its bounds to the last bit.
    void project();

    /// Gives the bodies the tried impulses.
    void hand_out();

    void accept();

    /// The longest of a few steps from the impulses that stand to the best that was found which
    /// lowers the residual; none where none does.
    void step_towards_best();

    RowSystem& s_;
    std::uint32_t first_;
    std::size_t n_;
    SolverScratch& t_;
    double give_ = 0.0;
};

}  // namespace zoned::physics
