// Midpoint rule: Runge-Kutta of order two.
#pragma once

#include "server/physics/integrator/acceleration.h"

namespace zoned::physics {

/// The slopes in the middle, reached by half an Euler step, over the whole step. Order 2; two
/// accelerations a step. Not symplectic: an undamped oscillator grows by sqrt(1 + (omega h)^4 / 4)
/// a step, however short; a drag of c 1/s is stable for c h <= 2. Constant acceleration is exact.
/// Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", II.1 (Runge 1895).
template <class V>
struct Rk2 : NoMemory {
    using Real = RealOf<V>;

    template <Acceleration<V> A>
    void step(V& x, V& v, Real t, Real h, const A& a) const {
        const Real half = Real(0.5) * h;
        const V middle = v + half * a(x, v, t);
        const V slope = a(V(x + half * v), middle, t + half);
        x += h * middle;
        v += h * slope;
    }
};

}  // namespace zoned::physics
