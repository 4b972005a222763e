// Explicit Euler: both old slopes over the whole step.
#pragma once

#include "server/physics/integrator/acceleration.h"

namespace zoned::physics {

/// x' = x + h v, v' = v + h a(x, v, t). Order 1; one acceleration a step. Not symplectic: an
/// undamped oscillator of omega rad/s grows by sqrt(1 + (omega h)^2) in each step, however short.
/// Stable where |1 + h lambda| <= 1: with the damping ratio z <= 1 for omega h <= 2 z, for a drag
/// of c 1/s for c h <= 2. Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I",
/// II.1; Hairer, Lubich, Wanner, "Geometric Numerical Integration", I.1.2.
template <class V>
struct ExplicitEuler : NoMemory {
    using Real = RealOf<V>;

    template <Acceleration<V> A>
    void step(V& x, V& v, Real t, Real h, const A& a) const {
        const V slope = a(x, v, t);
        x += h * v;
        v += h * slope;
    }
};

}  // namespace zoned::physics
