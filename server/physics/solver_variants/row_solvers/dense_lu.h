// Dense LU: solves dense systems by elimination with partial pivoting, in place, no allocation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace zoned::physics {

/// Factors the n x n row-major matrix (G. Golub, C. Van Loan, "Matrix Computations", 4th ed.,
/// algorithm 3.4.1). False when a pivot is zero or not finite. Zeros below the pivots cost nothing.
bool factor_dense(std::size_t n, std::span<double> matrix, std::span<std::uint32_t> pivots);

/// x <- matrix^-1 x with the factors that `factor_dense` left.
void solve_dense(std::size_t n,
                 std::span<const double> factors,
                 std::span<const std::uint32_t> pivots,
                 std::span<double> x);

}  // namespace zoned::physics
