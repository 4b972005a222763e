// build: computes
// EnvelopeSolver against dense factorisations, and its results on dependent rows.
#include "server/physics/joints/envelope_solver.h"

#include "shared/core/rng.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>

namespace zoned::physics {
namespace {

/// A random envelope: each row begins somewhere within `width` columns before the diagonal.
std::vector<std::uint32_t> any_envelope(core::Rng& rng, std::uint32_t size, std::uint32_t width) {
    std::vector<std::uint32_t> start(size);
    for (std::uint32_t i = 0; i < size; ++i) {
        start[i] = i - rng.below(std::min(i, width) + 1);
    }
    return start;
}

/// Symmetric, inside the envelope, and positive definite: L D L^T with L inside it and D > 0, which
/// stays inside because an envelope has no fill.
Eigen::MatrixXd any_matrix(core::Rng& rng, const std::vector<std::uint32_t>& start) {
    const auto n = static_cast<Eigen::Index>(start.size());
    Eigen::MatrixXd l = Eigen::MatrixXd::Identity(n, n);
    Eigen::VectorXd d(n);
    for (Eigen::Index i = 0; i < n; ++i) {
        d[i] = static_cast<double>(rng.range(0.1F, 10.0F));
        for (Eigen::Index j = start[static_cast<std::size_t>(i)]; j < i; ++j) {
            l(i, j) = static_cast<double>(rng.range(-0.5F, 0.5F));
        }
    }
    return l * d.asDiagonal() * l.transpose();
}

void fill(const Eigen::MatrixXd& a,
          const std::vector<std::uint32_t>& start,
          EnvelopeSolver& solver) {
    for (std::size_t i = 0; i < start.size(); ++i) {
        for (std::size_t j = start[i]; j <= i; ++j) {
            solver.at(i, j) = a(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        }
    }
}

std::vector<double> solve(const Eigen::MatrixXd& a,
                          const std::vector<std::uint32_t>& start,
                          const Eigen::VectorXd& b) {
    EnvelopeSolver solver;
    solver.shape(start);
    fill(a, start, solver);
    solver.factor();
    std::vector<double> x(b.begin(), b.end());
    solver.solve(x);
    return x;
}

TEST(EnvelopeSolver, AgreesWithADenseFactorisation) {
    core::Rng rng(11);
    for (int i = 0; i < 300; ++i) {
        const std::uint32_t size = 1 + rng.below(60);
        const auto start = any_envelope(rng, size, 1 + rng.below(20));
        const Eigen::MatrixXd a = any_matrix(rng, start);
        Eigen::VectorXd b(size);
        for (double& value : b) {
            value = static_cast<double>(rng.range(-1.0F, 1.0F));
        }
        const Eigen::VectorXd exact = a.ldlt().solve(b);
        const std::vector<double> x = solve(a, start, b);
        const Eigen::Map<const Eigen::VectorXd> ours(x.data(), size);
        // Backward stability (Higham, "Accuracy and Stability of Numerical Algorithms", 2002,
        // theorem 10.4): the residual is within a few n eps |A| |x|.
        const double bound = 10.0 * size * DBL_EPSILON * a.norm() * exact.norm();
        ASSERT_LT((a * ours - b).norm(), bound) << i;
        const double condition = a.norm() * a.inverse().norm();
        ASSERT_LT((ours - exact).norm(), 20.0 * size * DBL_EPSILON * condition * exact.norm()) << i;
    }
}

TEST(EnvelopeSolver, SolvesAgainAfterItIsCleared) {
    core::Rng rng(2);
    const auto start = any_envelope(rng, 30, 7);
    EnvelopeSolver solver;
    solver.shape(start);
    for (int i = 0; i < 3; ++i) {
        const Eigen::MatrixXd a = any_matrix(rng, start);
        solver.clear(0, solver.size());
        fill(a, start, solver);
        solver.factor();
        std::vector<double> x(30, 1.0);
        solver.solve(x);
        const Eigen::Map<const Eigen::VectorXd> ours(x.data(), 30);
        ASSERT_LT((a * ours - Eigen::VectorXd::Ones(30)).norm(), 1e-9) << i;
    }
}

TEST(EnvelopeSolver, MeetsAllRowsWhereSomeDependOnOthers) {
    // Redundant rows, as a closed loop has: J of rank r < n, A = J J^T, b = J y is consistent, and
    // any solution will do.
    core::Rng rng(5);
    for (int i = 0; i < 100; ++i) {
        const Eigen::Index n = 6 + rng.below(20);
        const Eigen::Index rank = 1 + rng.below(static_cast<std::uint32_t>(n) - 1);
        Eigen::MatrixXd j(n, rank);
        Eigen::VectorXd y(rank);
        for (Eigen::Index r = 0; r < rank; ++r) {
            y[r] = static_cast<double>(rng.range(-1.0F, 1.0F));
            for (Eigen::Index k = 0; k < n; ++k) {
                j(k, r) = static_cast<double>(rng.range(-1.0F, 1.0F));
            }
        }
        const Eigen::MatrixXd a = j * j.transpose();
        const Eigen::VectorXd b = j * y;
        const std::vector<std::uint32_t> start(static_cast<std::size_t>(n), 0);
        const std::vector<double> x = solve(a, start, b);
        const Eigen::Map<const Eigen::VectorXd> ours(x.data(), n);
        ASSERT_TRUE(ours.allFinite()) << i;
        // A pivot is dropped below 1e-10 of its diagonal entry. Its residual is of that order times
        // the unknowns, which themselves may be as large as 1 / (smallest pivot).
        ASSERT_LT((a * ours - b).norm(), 1e-6 * (1.0 + ours.norm())) << i;
    }
}

TEST(EnvelopeSolver, StaysFiniteWhereRowsContradictEachOther) {
    // Two identical rows with different right-hand sides, a row of zeros, and a negative diagonal.
    const std::vector<std::uint32_t> start{0, 0, 2, 3};
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(4, 4);
    a.topLeftCorner(2, 2).setOnes();
    a(3, 3) = -1.0;
    const std::vector<double> x = solve(a, start, Eigen::Vector4d(1.0, 2.0, 3.0, 4.0));
    EXPECT_EQ(x, (std::vector<double>{1.0, 0.0, 0.0, 0.0}));
}

TEST(EnvelopeSolver, CostGrowsWithTheLengthOfAChainAndTheSquareOfItsWidth) {
    const auto band = [](std::uint32_t size, std::uint32_t width) {
        std::vector<std::uint32_t> start(size);
        for (std::uint32_t i = 0; i < size; ++i) {
            start[i] = i - std::min(i, width);
        }
        return EnvelopeSolver::cost(start);
    };
    EXPECT_NEAR(band(2000, 5) / band(1000, 5), 2.0, 0.02);
    EXPECT_NEAR(band(1000, 19) / band(1000, 9), 4.0, 0.1);
}

}  // namespace
}  // namespace zoned::physics
