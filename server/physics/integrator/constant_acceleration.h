// Constant acceleration: the default integrator of free bodies and particles.
#pragma once

#include "server/physics/integrator/acceleration.h"

namespace zoned::physics {

/// The acceleration at the start of the step holds through it: v' = v + h a(x, v, t), x' = x + h (v
/// + v') / 2, which is exact where it is constant. An acceleration may separate its drag
/// (WithLinearDrag). Such a drag is taken implicitly: v' = (v + h pull) / (1 + h drag), stable for
/// any drag. The mean of both velocities rounds as they do: a rising body falls back the same way,
/// and rounding does not add up to energy.
///
/// Order 1 where the acceleration changes; one acceleration a step. Not symplectic: an oscillator
/// of omega rad/s and damping ratio z is stable for omega h <= 4 z (trace and determinant of the
/// step matrix), without damping never. Where the drag is not separate, omega h <= 1 / z is needed
/// as well. For free flight, not for springs. (Taylor's method of order 2 for x: Hairer, Norsett,
/// Wanner, "Solving Ordinary Differential Equations I", I.8.)
template <class V>
struct ConstantAcceleration : NoMemory {
    using Real = RealOf<V>;

    template <Acceleration<V> A>
    void step(V& x, V& v, Real t, Real h, const A& a) const {
        V end = v;
        if constexpr (WithLinearDrag<A, V>) {
            end = (v + h * a.pull(x, t)) / (1 + h * a.drag());
        } else {
            end = v + h * a(x, v, t);
        }
        x += (Real(0.5) * h) * (v + end);
        v = end;
    }
};

}  // namespace zoned::physics
