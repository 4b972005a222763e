// Implicit Euler: the slopes at the end of the step, by Newton's method on the new velocity.
#pragma once

#include "server/physics/integrator/acceleration.h"
#include "server/physics/integrator/small_solve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace zoned::physics {

/// v' = v + h a(x + h v', v', t + h), x' = x + h v'. Order 1. Stable for any step on any spring and
/// drag (A- and L-stable: Hairer, Wanner, "Solving Ordinary Differential Equations II", IV.3), at
/// the price of numerical damping: an undamped oscillator shrinks by 1 / sqrt(1 + (omega h)^2) a
/// step. Not symplectic.
///
/// Newton's method solves for v' with the matrix I - h da/dv - h^2 da/dx. The derivatives come from
/// the acceleration itself where it has them (WithJacobian), else from differences, one more
/// acceleration for each coordinate. Linear forces take one iteration and a second one to see it.
/// With `iterations` = 1 the system is linearised and solved once (Baraff, Witkin, "Large steps in
/// cloth simulation", SIGGRAPH 1998, 3; Hairer, Wanner, IV.7): the same for linear forces, cheaper
/// and still of order 1 for others. Things side by side converge each by itself: the result of one
/// does not depend on its neighbours.
template <class V>
class ImplicitEuler : public NoMemory {
  public:
    using Real = RealOf<V>;

    int iterations = 12;  ///< at most; 1: linearised
    /// Ends when no coordinate of v' changes by more than this share of the largest.
    Real tolerance = 32 * std::numeric_limits<Real>::epsilon();
    std::uint32_t unsolved = 0;  ///< steps whose iterations did not get there (linearised: none)

    template <Acceleration<V> A>
    void step(V& x, V& v, Real t, Real h, const A& a) {
        V to = v;
        Pending pending;
        pending.fill(true);
        for (int i = 0; i < iterations && any(pending); ++i) {
            iterate(x, v, t, h, a, to, pending);
        }
        unsolved += iterations > 1 && any(pending) ? 1 : 0;
        x += h * to;
        v = to;
    }

  private:
    using In = Layout<V>;
    static constexpr int kD = In::kCoordinates;
    using Small = std::array<Real, static_cast<std::size_t>(kD)>;
    using Pending = std::array<bool, static_cast<std::size_t>(In::kThings)>;

    static bool any(const Pending& pending) {
        return std::find(pending.begin(), pending.end(), true) != pending.end();
    }

    template <class A>
    void iterate(const V& x, const V& v, Real t, Real h, const A& a, V& to, Pending& pending) {
        const auto slope = [&](const V& w) {
            return V(a(V(x + h * w), w, t + h));
        };
        const V at = slope(to);
        V residual = v + h * at - to;
        JacobianOf<V> change;  // of h a by v'
        if constexpr (WithJacobian<A, V>) {
            JacobianOf<V> dx;
            a.jacobian(V(x + h * to), to, t + h, dx, change);
            change = h * change + (h * h) * dx;
        } else {
            take_differences(slope, at, to, h, change);
        }
        for (int thing = 0; thing < In::kThings; ++thing) {
            if (pending[static_cast<std::size_t>(thing)]) {
                const Small delta = newton_step(residual, change, thing);
                for (int i = 0; i < kD; ++i) {
                    In::at(to, thing, i) += delta[static_cast<std::size_t>(i)];
                }
                pending[static_cast<std::size_t>(thing)] = !settled(delta, thing, to, v);
            }
        }
    }

    static Small newton_step(V& residual, JacobianOf<V>& change, int thing) {
        Small right{};
        std::array<Small, static_cast<std::size_t>(kD)> matrix{};
        for (int i = 0; i < kD; ++i) {
            right[static_cast<std::size_t>(i)] = In::at(residual, thing, i);
            for (int j = 0; j < kD; ++j) {
                matrix[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] =
                    In::at(change, thing, i, j);
            }
        }
        return solve_newton(right, matrix);
    }

    static Real largest(const V& state, int thing) {
        Real most = 0;
        for (int i = 0; i < kD; ++i) {
            most = std::max(most, std::abs(In::at(state, thing, i)));
        }
        return most;
    }

    /// False for values that are not finite.
    [[nodiscard]] bool settled(const Small& delta, int thing, const V& to, const V& from) const {
        const Real most = tolerance * std::max(largest(to, thing), largest(from, thing));
        return std::all_of(
            delta.begin(), delta.end(), [most](Real d) { return std::abs(d) <= most; });
    }

    /// Forward differences with the step that balances rounding against curvature, for speeds of
    /// about 1 m/s and more.
    template <class Slope>
    static void take_differences(const Slope& slope,
                                 const V& at,
                                 const V& to,
                                 Real h,
                                 JacobianOf<V>& out) {
        const Real share = std::sqrt(std::numeric_limits<Real>::epsilon());
        for (int j = 0; j < kD; ++j) {
            V moved_to = to;
            std::array<Real, static_cast<std::size_t>(In::kThings)> by{};
            for (int thing = 0; thing < In::kThings; ++thing) {
                by[static_cast<std::size_t>(thing)] = share * std::max(Real(1), largest(to, thing));
                In::at(moved_to, thing, j) += by[static_cast<std::size_t>(thing)];
            }
            const V moved = slope(moved_to);
            for (int thing = 0; thing < In::kThings; ++thing) {
                for (int i = 0; i < kD; ++i) {
                    In::at(out, thing, i, j) = h / by[static_cast<std::size_t>(thing)] *
                                               (In::at(moved, thing, i) - In::at(at, thing, i));
                }
            }
        }
    }
};

}  // namespace zoned::physics
