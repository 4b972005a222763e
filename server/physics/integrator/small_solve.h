// The small linear systems of implicit steps.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace zoned::physics {

/// delta of (I - change) delta = residual, `change` by rows: elimination with the largest pivot of
/// each column, sums in a fixed order (Eigen's depend on the width of the target's registers). Not
/// finite where the matrix has no inverse.
template <class Real, std::size_t kD>
std::array<Real, kD> solve_newton(std::array<Real, kD> residual,
                                  std::array<std::array<Real, kD>, kD> change) {
    auto& m = change;
    for (std::size_t i = 0; i < kD; ++i) {
        for (std::size_t j = 0; j < kD; ++j) {
            m[i][j] = (i == j ? Real(1) : Real(0)) - m[i][j];
        }
    }
    for (std::size_t c = 0; c < kD; ++c) {
        std::size_t best = c;
        for (std::size_t r = c + 1; r < kD; ++r) {
            best = std::abs(m[r][c]) > std::abs(m[best][c]) ? r : best;
        }
        std::swap(m[c], m[best]);
        std::swap(residual[c], residual[best]);
        for (std::size_t r = c + 1; r < kD; ++r) {
            const Real share = m[r][c] / m[c][c];
            for (std::size_t j = c + 1; j < kD; ++j) {
                m[r][j] -= share * m[c][j];
            }
            residual[r] -= share * residual[c];
        }
    }
    for (std::size_t c = kD; c-- > 0;) {
        for (std::size_t j = c + 1; j < kD; ++j) {
            residual[c] -= m[c][j] * residual[j];
        }
        residual[c] /= m[c][c];
    }
    return residual;
}

}  // namespace zoned::physics
