// Integrators: one interface to all methods that integrate x'' = a(x, x', t), and their choice.
#pragma once

#include "server/physics/integrator/adaptive.h"
#include "server/physics/integrator/constant_acceleration.h"
#include "server/physics/integrator/explicit_euler.h"
#include "server/physics/integrator/implicit_euler.h"
#include "server/physics/integrator/integrator_kind.h"
#include "server/physics/integrator/rk2.h"
#include "server/physics/integrator/rk4.h"
#include "server/physics/integrator/semi_implicit_euler.h"
#include "server/physics/integrator/velocity_verlet.h"
#include "server/physics/integrator/verlet.h"

#include <utility>

namespace zoned::physics {

/// Every method is a small value that gets the start of a motion and then carries it on:
///
///     method.start(x, v, t, h, a);      before the first step, and when h changes or x or v jump
///     method.step(x, v, t, h, a);       x (m) and v (m/s) from the time t (s) to t + h, h > 0
///
/// The state V is a fixed-size vector or things side by side, in float or double, and `a` is an
/// Acceleration (see acceleration.h). Same inputs, same bits; no allocation.
///
/// Calls use(method) with a fresh method of that kind. Loops over steps and things belong into
/// `use`: it is compiled once for each method, and nothing is chosen inside.
template <class V, class Use>
decltype(auto) with_integrator(IntegratorKind kind, Use&& use) {
    switch (kind) {
        case IntegratorKind::kExplicitEuler:
            return std::forward<Use>(use)(ExplicitEuler<V>());
        case IntegratorKind::kImplicitEuler:
            return std::forward<Use>(use)(ImplicitEuler<V>());
        case IntegratorKind::kSemiImplicitEuler:
            return std::forward<Use>(use)(SemiImplicitEuler<V>());
        case IntegratorKind::kVerlet:
            return std::forward<Use>(use)(Verlet<V>());
        case IntegratorKind::kVelocityVerlet:
            return std::forward<Use>(use)(VelocityVerlet<V>());
        case IntegratorKind::kRk2:
            return std::forward<Use>(use)(Rk2<V>());
        case IntegratorKind::kRk4:
            return std::forward<Use>(use)(Rk4<V>());
        case IntegratorKind::kAdaptive:
            return std::forward<Use>(use)(Adaptive<V>());
        case IntegratorKind::kDefault:
            break;
    }
    return std::forward<Use>(use)(ConstantAcceleration<V>());
}

}  // namespace zoned::physics
