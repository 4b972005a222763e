// The classical Runge-Kutta method of order four.
#pragma once

#include "server/physics/integrator/acceleration.h"

namespace zoned::physics {

/// Order 4; four accelerations a step. Not symplectic: an undamped oscillator loses
/// (omega h)^6 / 144 of its amplitude a step, and grows from omega h = 2 sqrt(2) on; a drag of c
/// 1/s is stable for c h <= 2.785. Constant acceleration is exact. Hairer, Norsett, Wanner,
/// "Solving Ordinary Differential Equations I", II.1 (Kutta 1901); Hairer, Wanner, "Solving
/// Ordinary Differential Equations II", IV.2 (stability).
template <class V>
struct Rk4 : NoMemory {
    using Real = RealOf<V>;

    template <Acceleration<V> A>
    void step(V& x, V& v, Real t, Real h, const A& a) const {
        const Real half = Real(0.5) * h;
        const V a1 = a(x, v, t);
        const V v2 = v + half * a1;
        const V a2 = a(V(x + half * v), v2, t + half);
        const V v3 = v + half * a2;
        const V a3 = a(V(x + half * v2), v3, t + half);
        const V v4 = v + h * a3;
        const V a4 = a(V(x + h * v3), v4, t + h);
        x += (h / 6) * (v + 2 * (v2 + v3) + v4);
        v += (h / 6) * (a1 + 2 * (a2 + a3) + a4);
    }
};

}  // namespace zoned::physics
