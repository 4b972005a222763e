// Integrator test: fixtures for tests of integrators, with runs over a time and theory's values.
#pragma once

#include "server/physics/integrator/integrator.h"
#include "tests/scenario/motions.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::physics {

using scenario::MotionState;

/// `steps` steps of h seconds from the time zero, by a method that `prepare` may set.
template <class Method, class V, class A>
MotionState<V> carried(Method& method, MotionState<V> s, double h, long steps, const A& a) {
    method.start(s.x, s.v, 0.0, h, a);
    for (long i = 0; i < steps; ++i) {
        method.step(s.x, s.v, static_cast<double>(i) * h, h, a);
    }
    return s;
}

template <class V, class A>
MotionState<V> run_motion(IntegratorKind kind,
                          const MotionState<V>& start,
                          double h,
                          long steps,
                          const A& a) {
    return with_integrator<V>(kind,
                              [&](auto method) { return carried(method, start, h, steps, a); });
}

/// Of both halves of the state.
template <class V>
double apart(const MotionState<V>& a, const MotionState<V>& b) {
    return std::hypot((a.x - b.x).norm(), (a.v - b.v).norm());
}

/// Methods with steps of a given length, and the order that theory gives them.
struct Order {
    IntegratorKind kind;
    double order;
};

inline constexpr std::array kOrders{Order{IntegratorKind::kDefault, 1},
                                    Order{IntegratorKind::kExplicitEuler, 1},
                                    Order{IntegratorKind::kImplicitEuler, 1},
                                    Order{IntegratorKind::kSemiImplicitEuler, 1},
                                    Order{IntegratorKind::kVerlet, 2},
                                    Order{IntegratorKind::kVelocityVerlet, 2},
                                    Order{IntegratorKind::kRk2, 2},
                                    Order{IntegratorKind::kRk4, 4}};

}  // namespace zoned::physics
