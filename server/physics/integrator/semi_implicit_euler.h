// Semi-implicit Euler: the new velocity moves the position.
#pragma once

#include "server/physics/integrator/acceleration.h"

namespace zoned::physics {

/// v' = v + h a(x, v, t), x' = x + h v'. Order 1; one acceleration a step. Symplectic where a is a
/// gradient that depends on x alone: the energy swings by O(h) and does not drift. An oscillator is
/// stable for omega h <= 2, with the damping ratio z for omega h <= 2 (sqrt(1 + z^2) - z). Under
/// constant acceleration positions are off by g h t / 2. Hairer, Lubich, Wanner, "Geometric
/// Numerical Integration", I.1.2 and VI.3 ("symplectic Euler").
template <class V>
struct SemiImplicitEuler : NoMemory {
    using Real = RealOf<V>;

    template <Acceleration<V> A>
    void step(V& x, V& v, Real t, Real h, const A& a) const {
        v += h * a(x, v, t);
        x += h * v;
    }
};

}  // namespace zoned::physics
