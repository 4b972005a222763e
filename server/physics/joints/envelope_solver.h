// EnvelopeSolver: linear systems of symmetric positive definite matrices that are narrow.
#pragma once

#include "server/physics/simd/lanes.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace zoned::physics {

/// Factors A = U^T D^-1 U inside the envelope: in row i nothing stands before column start(i), and
/// nothing will (George, Liu, "Computer Solution of Large Sparse Positive Definite Systems", 1981,
/// chapter 4). A chain of n joints costs O(n). In doubles: masses of a thousand to one leave a
/// condition number of a million.
///
/// Row k of U lies in one piece, so that a step of the elimination takes a multiple of one row from
/// another, several numbers at a time. Sums are taken in one order, whatever the processor.
class EnvelopeSolver {
  public:
    /// Takes the shape of the matrix: the first column of each row, start[i] <= i. All entries
    /// become zero.
    void shape(std::span<const std::uint32_t> start);

    /// Entry of row i, column j, start(i) <= j <= i.
    [[nodiscard]] double& at(std::size_t i, std::size_t j) {
        return entries_[static_cast<std::size_t>(first_[j]) + i];
    }

    /// Adds to the entries of column j and of rows i to i + 7, of which those before j count for
    /// nothing, and those after the last that reaches j have to be zero.
    void add_column(std::size_t i, std::size_t j, const Lanes& eight) {
        typedef double Doubles __attribute__((vector_size(64)));
        double* const to = row(j) + i;
        Doubles sum;
        std::memcpy(&sum, to, sizeof(sum));
        sum += __builtin_convertvector(eight, Doubles);
        std::memcpy(to, &sum, sizeof(sum));
    }

    /// Factors rows begin..end - 1 in place; no row among them may reach before `begin`. A row
    /// whose pivot is not more than this share of its diagonal depends on those before: its unknown
    /// is zero.
    void factor(std::size_t begin, std::size_t end, double least = 1.0e-10);

    void factor() { factor(0, size()); }

    /// Sets all entries of these rows to zero.
    void clear(std::size_t begin, std::size_t end);

    /// Solves A x = b in place for rows begin..end - 1; `factor` must have been called for them.
    void solve(std::span<double> b, std::size_t begin, std::size_t end);

    void solve(std::span<double> b) { solve(b, 0, size()); }

    [[nodiscard]] std::size_t size() const { return start_.size(); }

    /// Multiplications that a factorisation of rows of this shape takes, at most; `first` is the
    /// number of the first of them.
    [[nodiscard]] static double cost(std::span<const std::uint32_t> start, std::size_t first = 0);

  private:
    [[nodiscard]] double* row(std::size_t k) { return entries_.data() + first_[k]; }

    void solve_forward(double* x, std::size_t begin, std::size_t k);
    void solve_backward(double* x, std::size_t begin, std::size_t k);

    std::vector<std::uint32_t> start_;  // no later than that of any row after it
    std::vector<std::uint32_t> end_;    // of row k of U: its last column
    std::vector<std::ptrdiff_t>
        first_;  // of row k of U: so that entries_[first_[k] + j] is column j
    std::vector<double> entries_;
    std::vector<double> inverse_;  // of the pivots
    std::vector<double> work_;     // right-hand side, then unknowns; zeros behind
};

}  // namespace zoned::physics
