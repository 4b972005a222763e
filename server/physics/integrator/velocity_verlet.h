// Verlet's method in its velocity form: positions and velocities at the same times.
#pragma once

#include "server/physics/integrator/acceleration.h"

namespace zoned::physics {

/// x' = x + h v + h^2 a / 2, v' = v + h (a + a') / 2, with a' = a(x', v + h a, t + h): where the
/// acceleration depends on the velocity, that is predicted, and the order stays 2. Two
/// accelerations a step. Symplectic and time-reversible where a is a gradient of x alone: then the
/// energy swings by O(h^2) and does not drift. An oscillator without damping is stable for omega h
/// <= 2; a drag of c 1/s for c h <= 2. Constant acceleration is exact. Hairer, Lubich, Wanner,
/// "Geometric numerical integration illustrated by the Stoermer-Verlet method", Acta Numerica 12
/// (2003), 1.1 and 2.
template <class V>
struct VelocityVerlet : NoMemory {
    using Real = RealOf<V>;

    template <Acceleration<V> A>
    void step(V& x, V& v, Real t, Real h, const A& a) const {
        const Real half = Real(0.5) * h;
        const V before = a(x, v, t);
        const V ahead = v + h * before;
        x += half * (v + ahead);
        v += half * (before + a(x, ahead, t + h));
    }
};

}  // namespace zoned::physics
