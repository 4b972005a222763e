// Verlet's method in its position form (Stoermer): the next position from the last two.
#pragma once

#include "server/physics/integrator/acceleration.h"

namespace zoned::physics {

/// x[n+1] = 2 x[n] - x[n-1] + h^2 a(x[n], v, t[n]), from its first two positions. The velocity that
/// it reports is the central difference (x[n+1] - x[n-1]) / (2 h), so it always knows one position
/// more than it has reported. Steps of one length only: another length needs a new start. It stores
/// the step to the next position rather than that position: then roundings add up with the number
/// of steps, not with its square.
///
/// Order 2; one acceleration a step. Symplectic and time-reversible (to rounding; start_from with
/// the last two positions in the other order runs back) where a is a gradient of x alone. An
/// oscillator is stable for omega h <= 2. A velocity in the acceleration is extrapolated as (3 x[n]
/// - 4 x[n-1] + x[n-2]) / (2 h), which keeps order 2 at the price of stability. With the damping
/// ratio z, omega h <= 2 (sqrt(1 + 4 z^2) - 2 z), and a drag of c 1/s needs c h <= 1 (Jury's
/// criterion on the cubic that this gives). Constant acceleration is exact.
///
/// Hairer, Lubich, Wanner, "Geometric numerical integration illustrated by the Stoermer-Verlet
/// method", Acta Numerica 12 (2003), 1.1, 1.3 (start and velocities) and 2; "Geometric Numerical
/// Integration", VIII.5 (rounding).
template <class V>
class Verlet {
  public:
    using Real = RealOf<V>;

    /// The second position by Taylor's series, to the third order in h.
    template <Acceleration<V> A>
    void start(const V& x, const V& v, Real t, Real h, const A& a) {
        path_ = h * (v + (Real(0.5) * h) * a(x, v, t));
    }

    /// From two positions that lie a step apart; the first step goes to `second`.
    void start_from(const V& first, const V& second, Real h, V& x, V& v) {
        x = first;
        path_ = second - first;
        v = path_ / h;
    }

    /// `x` and `v` as start or the last step left them.
    template <Acceleration<V> A>
    void step(V& x, V& v, Real t, Real h, const A& a) {
        const V extrapolated = (2 / h) * path_ - v;
        x += path_;
        const V next = path_ + (h * h) * a(x, extrapolated, t + h);
        v = (path_ + next) / (2 * h);
        path_ = next;
    }

    /// From the position that it has reported to the next one, m.
    [[nodiscard]] const V& way() const { return path_; }

  private:
    V path_ = V::Zero();
};

}  // namespace zoned::physics
