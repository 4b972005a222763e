// EnvelopeSolver: linear systems of symmetric positive definite matrices that are narrow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::physics {

/// Factors A = L D L^T inside the envelope: in row i nothing stands before column start(i), and
/// nothing will (George, Liu, "Computer Solution of Large Sparse Positive Definite Systems", 1981,
/// chapter 4). A chain of n joints costs O(n). In doubles: masses of a thousand to one leave a
/// condition number of a million.
class EnvelopeSolver {
  public:
    /// Takes the shape of the matrix: the first column of each row, start[i] <= i. All entries
    /// become zero.
    void shape(std::span<const std::uint32_t> start);

    /// Entry of row i, column j, start(i) <= j <= i.
    [[nodiscard]] double& at(std::size_t i, std::size_t j) { return entries_[first_[i] + j]; }

    /// Factors rows begin..end - 1 in place; no row among them may reach before `begin`. A row
    /// whose pivot is not more than this share of its diagonal depends on those before: its unknown
    /// is zero.
    void factor(std::size_t begin, std::size_t end, double least = 1.0e-10);

    void factor() { factor(0, size()); }

    /// Sets all entries of these rows to zero.
    void clear(std::size_t begin, std::size_t end);

    /// Solves A x = b in place for rows begin..end - 1; `factor` must have been called for them.
    void solve(std::span<double> b, std::size_t begin, std::size_t end) const;

    void solve(std::span<double> b) const { solve(b, 0, size()); }

    [[nodiscard]] std::size_t size() const { return start_.size(); }

    /// Multiplications that a factorisation of rows of this shape takes, at most; `first` is the
    /// number of the first of them.
    [[nodiscard]] static double cost(std::span<const std::uint32_t> start, std::size_t first = 0);

  private:
    std::vector<std::uint32_t> start_;
    std::vector<std::ptrdiff_t> first_;  // of row i: so that entries_[first_[i] + j] is column j
    std::vector<double> entries_;
    std::vector<double> inverse_;  // of the pivots
};

}  // namespace zoned::physics
