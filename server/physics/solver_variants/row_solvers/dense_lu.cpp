#include "server/physics/solver_variants/row_solvers/dense_lu.h"

#include <Eigen/Core>

#include <cmath>
#include <utility>

namespace zoned::physics {

namespace {

using RowMap = Eigen::Map<Eigen::ArrayXd>;
using ConstRowMap = Eigen::Map<const Eigen::ArrayXd>;

void swap_rows(std::size_t n, double* a, double* b) {
    RowMap(a, static_cast<Eigen::Index>(n)).swap(RowMap(b, static_cast<Eigen::Index>(n)));
}

}  // namespace

bool factor_dense(std::size_t n, std::span<double> matrix, std::span<std::uint32_t> pivots) {
    double* m = matrix.data();
    for (std::size_t k = 0; k < n; ++k) {
        std::size_t best = k;
        for (std::size_t i = k + 1; i < n; ++i) {
            if (std::abs(m[i * n + k]) > std::abs(m[best * n + k])) {
                best = i;
            }
        }
        pivots[k] = static_cast<std::uint32_t>(best);
        if (best != k) {
            swap_rows(n, m + k * n, m + best * n);
        }
        const double pivot = m[k * n + k];
        if (!(std::abs(pivot) > 0.0) || !std::isfinite(pivot)) {
            return false;
        }
        const auto rest = static_cast<Eigen::Index>(n - k - 1);
        const ConstRowMap from(m + k * n + k + 1, rest);
        for (std::size_t i = k + 1; i < n; ++i) {
            double& factor = m[i * n + k];
            if (factor != 0.0) {
                factor /= pivot;
                RowMap(m + i * n + k + 1, rest) -= factor * from;
            }
        }
    }
    return true;
}

void solve_dense(std::size_t n,
                 std::span<const double> factors,
                 std::span<const std::uint32_t> pivots,
                 std::span<double> x) {
    for (std::size_t k = 0; k < n; ++k) {
        std::swap(x[k], x[pivots[k]]);
    }
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            x[i] -= factors[i * n + j] * x[j];
        }
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t j = i + 1; j < n; ++j) {
            x[i] -= factors[i * n + j] * x[j];
        }
        x[i] /= factors[i * n + i];
    }
}

}  // namespace zoned::physics
