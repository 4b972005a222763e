// Least squares with forgetting: the weights that would have given the best recent predictions.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace zoned::wire::entropy {

/// Sums of the normal equations of N features (the upper triangle, row by row). Sums of several
/// packets are added. So samples can be learned later, when both sides are known to have seen them.
template <std::size_t N>
struct NormalSums {
    std::array<double, N*(N + 1) / 2> products{};
    std::array<double, N> targets{};
    bool any = false;

    void add(const std::array<double, N>& features, double target, double weight) {
        any = true;
        std::size_t at = 0;
        for (std::size_t i = 0; i < N; ++i) {
            const double scaled = weight * features[i];
            targets[i] += scaled * target;
            for (std::size_t j = i; j < N; ++j) {
                products[at++] += scaled * features[j];
            }
        }
    }
};

/// Exponentially forgetting least squares (S. Haykin, "Adaptive Filter Theory", 4th edition,
/// chapter 9), solved once per packet instead of being updated with each sample; drawn towards
/// given weights by a share of each feature's own power, so that features that never differ do no
/// harm. Plain double arithmetic in a fixed order: the same bits on both sides.
template <std::size_t N>
class LeastSquares {
  public:
    explicit LeastSquares(const std::array<double, N>& prior = {})
        : prior_(prior),
          weights_(prior) {}

    [[nodiscard]] double predict(const std::array<double, N>& features) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < N; ++i) {
            sum += weights_[i] * features[i];
        }
        return sum;
    }

    /// Weights change with solve() only.
    void learning(const NormalSums<N>& seen) {
        for (std::size_t i = 0; i < sums_.products.size(); ++i) {
            sums_.products[i] = kKeep * sums_.products[i] + seen.products[i];
        }
        for (std::size_t i = 0; i < N; ++i) {
            sums_.targets[i] = kKeep * sums_.targets[i] + seen.targets[i];
        }
    }

    /// Brings the weights up to date with what was learned (Cholesky).
    void solve() {
        std::array<std::array<double, N>, N> l{};
        std::array<double, N> y{};
        std::size_t at = 0;
        for (std::size_t i = 0; i < N; ++i) {
            for (std::size_t j = i; j < N; ++j) {
                l[j][i] = sums_.products[at++];
            }
            const double pull = kPull * l[i][i] + kFloor;
            y[i] = sums_.targets[i] + pull * prior_[i];
            l[i][i] += pull;
        }
        for (std::size_t i = 0; i < N; ++i) {
            for (std::size_t k = 0; k < i; ++k) {
                const double factor = l[i][k];
                for (std::size_t j = i; j < N; ++j) {
                    l[j][i] -= l[j][k] * factor;
                }
            }
            if (!(l[i][i] > 0.0)) {
                weights_ = prior_;
                return;
            }
            const double root = std::sqrt(l[i][i]);
            for (std::size_t j = i; j < N; ++j) {
                l[j][i] /= root;
            }
        }
        for (std::size_t i = 0; i < N; ++i) {
            for (std::size_t k = 0; k < i; ++k) {
                y[i] -= l[i][k] * y[k];
            }
            y[i] /= l[i][i];
        }
        for (std::size_t i = N; i-- > 0;) {
            for (std::size_t k = i + 1; k < N; ++k) {
                y[i] -= l[k][i] * y[k];
            }
            y[i] /= l[i][i];
        }
        weights_ = y;
    }

    [[nodiscard]] const std::array<double, N>& weights() const { return weights_; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(prior_, weights_, sums_);
    }

  private:
    static constexpr double kKeep = 1.0 - 1.0 / 64.0;  // per packet
    static constexpr double kPull = 0.01;
    static constexpr double kFloor = 1e-6;

    std::array<double, N> prior_;
    std::array<double, N> weights_;
    NormalSums<N> sums_;
};

}  // namespace zoned::wire::entropy
