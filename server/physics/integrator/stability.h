// Stability: the longest time step that an integrator bears on a spring or a drag.
#pragma once

#include "server/physics/integrator/integrator_kind.h"

#include <limits>
#include <string>

namespace zoned::physics {

/// Up to which time step a motion stays bounded.
struct StabilityLimit {
    static constexpr double kAny = std::numeric_limits<double>::infinity();

    double step_s = 0.0;  ///< the longest step, s; kAny: all are stable, 0: none is
    /// kAdaptive cuts its own steps: into pieces no longer than this, s. For others as `step_s`.
    double piece_s = 0.0;

    [[nodiscard]] bool stable(double h) const { return h <= step_s; }
};

/// The limit on x'' = -omega^2 x - 2 damping_ratio omega x', omega = sqrt(k / m) > 0 in rad/s,
/// damping_ratio >= 0: where no eigenvalue of the step's matrix lies outside the unit circle. Both
/// terms reach the method as one acceleration. Closed forms where there are any (see the method's
/// header), else the smallest omega h at which the spectral radius passes one, found to 1e-9 of it.
/// Hairer, Wanner, "Solving Ordinary Differential Equations II", IV.2; Hairer, Lubich, Wanner,
/// "Geometric Numerical Integration", I.1.
StabilityLimit stability_limit(IntegratorKind kind, double omega, double damping_ratio);

/// The limit on v' = -drag v, drag > 0 in 1/s. kDefault takes a separate drag (see WithLinearDrag),
/// as free bodies have it, and bears any.
StabilityLimit drag_limit(IntegratorKind kind, double drag);

/// Why a method is refused for a spring and a step of h seconds: names both, omega h and the limit.
/// Empty where the step is stable.
std::string why_unstable(IntegratorKind kind, double omega, double damping_ratio, double h);

/// The same for a drag, >= 0 in 1/s.
std::string why_unstable_drag(IntegratorKind kind, double drag, double h);

/// Empty for an integrator that can move the bodies of a scene, otherwise the reason.
std::string why_unfit_integrator(IntegratorKind kind);

}  // namespace zoned::physics
