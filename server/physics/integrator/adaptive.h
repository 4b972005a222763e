// Dormand and Prince's pair of orders 5 and 4: cuts its steps so that its own error keeps a bound.
#pragma once

#include "server/physics/integrator/acceleration.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace zoned::physics {

/// Bounds of an adaptive integration.
struct AdaptiveOptions {
    /// The error that a step may add to a coordinate: `absolute` (m, or m/s for velocities) +
    /// `relative` x its size.
    double relative = 1.0e-6;
    double absolute = 1.0e-9;
    std::uint32_t most_pieces = 10'000;  ///< per step, refused ones included
};

/// Counts of an adaptive integration since it was made.
struct AdaptiveReport {
    std::uint64_t pieces = 0;  ///< that were taken
    std::uint64_t refused = 0;
    bool gave_up = false;  ///< too many pieces, pieces too short for the type, or not finite
    double reached = 0.0;  ///< the time up to which the last step came, s
};

/// Order 5, with an estimate of order 4 beside it; six accelerations a piece and one a step. Not
/// symplectic. Each piece is as long as the estimate allows: the largest share of the tolerance
/// that a coordinate takes is kept below one (a maximum, not a mean: the same bits for any order of
/// summation). Stiff forces cost pieces (|lambda| h <= 3.3 on the real axis), not stability. Things
/// side by side share their pieces.
///
/// Dormand, Prince, "A family of embedded Runge-Kutta formulae", J. Comp. Appl. Math. 6 (1980),
/// table 2; Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", II.4 and II.5
/// (control of steps); Hairer, Wanner, "Solving Ordinary Differential Equations II", IV.2
/// (Gustafsson's PI control, beta = 0.04).
template <class V>
class Adaptive : public NoMemory {
  public:
    using Real = RealOf<V>;

    AdaptiveOptions options;
    AdaptiveReport report;

    /// From t to t + h, h > 0. Where it gives up, the state is that at `report.reached`.
    template <Acceleration<V> A>
    void step(V& x, V& v, Real t, Real h, const A& a) {
        Real done = 0;
        Real piece = next_ > 0 ? std::min(next_, h) : h;
        bool after_refusal = false;
        std::array<V, 7> slopes;
        slopes[0] = a(x, v, t);
        for (std::uint32_t tries = 0; done < h; ++tries) {
            // A step that would leave a sliver goes to the end.
            const bool last = done + Real(1.01) * piece >= h;
            const Real length = last ? h - done : piece;
            if (tries == options.most_pieces || !(done + length > done)) {
                return give_up(t + done);
            }
            V to_x = x;
            V to_v = v;
            const Real error = try_piece(to_x, to_v, t + done, length, a, slopes);
            if (error <= 1) {
                x = to_x;
                v = to_v;
                slopes[0] = slopes[6];
                done = last ? h : done + length;
                const Real grown = length * factor(error, after_refusal);
                next_ = last ? std::max(grown, piece) : grown;
                piece = grown;
                before_ = std::max(error, Real(1.0e-4));
                after_refusal = false;
                ++report.pieces;
            } else {
                // Not finite: a tenth, as good a guess as any.
                const bool finite = std::isfinite(error);
                piece = length *
                        (finite ? std::max(Real(0.2), kSafe / elementary::pow(error, kExponent))
                                : Real(0.1));
                next_ = piece;
                after_refusal = true;
                ++report.refused;
            }
        }
        report.reached = static_cast<double>(t + h);
    }

  private:
    static constexpr Real kSafe = Real(0.9);
    static constexpr Real kBeta = Real(0.04);
    static constexpr Real kExponent = Real(0.2) - Real(0.75) * kBeta;

    void give_up(Real reached) {
        report.gave_up = true;
        report.reached = static_cast<double>(reached);
    }

    [[nodiscard]] Real factor(Real error, bool after_refusal) const {
        const Real most = after_refusal ? Real(1) : Real(10);
        if (error <= 0) {
            return most;
        }
        const Real wanted =
            kSafe * elementary::pow(before_, kBeta) / elementary::pow(error, kExponent);
        return std::clamp(wanted, Real(0.2), most);
    }

    /// Moves a copy of the state; `slopes[0]` in, the others out. The error as a share of the
    /// tolerance.
    template <class A>
    Real try_piece(V& x, V& v, Real t, Real h, const A& a, std::array<V, 7>& k) const {
        // Rows of table 2: the stages, of which the last is the result of order 5.
        static constexpr std::array<std::array<double, 6>, 6> kStage{{
            {1.0 / 5},
            {3.0 / 40, 9.0 / 40},
            {44.0 / 45, -56.0 / 15, 32.0 / 9},
            {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
            {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
            {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
        }};
        static constexpr std::array<double, 6> kTime{1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0};
        // Order 5 less order 4.
        static constexpr std::array<double, 7> kError{71.0 / 57600,
                                                      0.0,
                                                      -71.0 / 16695,
                                                      71.0 / 1920,
                                                      -17253.0 / 339200,
                                                      22.0 / 525,
                                                      -1.0 / 40};
        const V from_x = x;
        const V from_v = v;
        std::array<V, 7> w;  // velocities of the stages
        w[0] = v;
        for (std::size_t s = 0; s < 6; ++s) {
            V dx = Real(kStage[s][0]) * w[0];
            V dv = Real(kStage[s][0]) * k[0];
            for (std::size_t j = 1; j <= s; ++j) {
                dx += Real(kStage[s][j]) * w[j];
                dv += Real(kStage[s][j]) * k[j];
            }
            x = from_x + h * dx;
            v = from_v + h * dv;
            w[s + 1] = v;
            k[s + 1] = a(x, v, t + Real(kTime[s]) * h);
        }
        V error_x = Real(kError[0]) * w[0];
        V error_v = Real(kError[0]) * k[0];
        for (std::size_t j = 2; j < 7; ++j) {
            error_x += Real(kError[j]) * w[j];
            error_v += Real(kError[j]) * k[j];
        }
        return std::max(share(error_x, h, from_x, x), share(error_v, h, from_v, v));
    }

    /// The largest share of the tolerance; infinity where anything is not finite.
    [[nodiscard]] Real share(const V& error, Real h, const V& from, const V& to) const {
        Real most = 0;
        for (Eigen::Index i = 0; i < error.size(); ++i) {
            const Real size = std::max(std::abs(from.coeff(i)), std::abs(to.coeff(i)));
            const Real allowed = Real(options.absolute) + Real(options.relative) * size;
            const Real part = std::abs(h * error.coeff(i)) / allowed;
            if (!std::isfinite(part)) {
                return std::numeric_limits<Real>::infinity();
            }
            most = std::max(most, part);
        }
        return most;
    }

    Real next_ = 0;  // length of piece to begin with; 0: the whole step
    Real before_ = Real(1.0e-4);
};

}  // namespace zoned::physics
