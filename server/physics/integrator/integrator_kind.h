// IntegratorKind: the integrators by name.
#pragma once

#include <array>
#include <cstdint>

namespace zoned::physics {

/// Methods for x'' = a(x, x', t); each has a file of its own in this folder, and integrator.h
/// chooses among them. `zoned-bench integrators` measures all of them.
enum class IntegratorKind : std::uint8_t {
    kDefault,        ///< constant_acceleration.h: moves free bodies unless the config names another
    kExplicitEuler,  ///< explicit_euler.h
    kImplicitEuler,  ///< implicit_euler.h
    kSemiImplicitEuler,  ///< semi_implicit_euler.h
    kVerlet,             ///< verlet.h: positions alone; not in a Scene, see why_unfit_integrator
    kVelocityVerlet,     ///< velocity_verlet.h
    kRk2,                ///< rk2.h: midpoint rule
    kRk4,                ///< rk4.h: the classical Runge-Kutta method
    kAdaptive,           ///< adaptive.h: Dormand-Prince 5(4), cuts its steps by its own error
};

inline constexpr std::array kIntegratorKinds{IntegratorKind::kDefault,
                                             IntegratorKind::kExplicitEuler,
                                             IntegratorKind::kImplicitEuler,
                                             IntegratorKind::kSemiImplicitEuler,
                                             IntegratorKind::kVerlet,
                                             IntegratorKind::kVelocityVerlet,
                                             IntegratorKind::kRk2,
                                             IntegratorKind::kRk4,
                                             IntegratorKind::kAdaptive};

/// As benchmarks and messages name it.
constexpr const char* name_of(IntegratorKind kind) {
    constexpr std::array kNames{"default",
                                "explicit_euler",
                                "implicit_euler",
                                "semi_implicit_euler",
                                "verlet",
                                "velocity_verlet",
                                "rk2",
                                "rk4",
                                "adaptive"};
    const auto i = static_cast<std::size_t>(kind);
    return i < kNames.size() ? kNames[i] : "unknown";
}

}  // namespace zoned::physics
