// Reference of a free spin: Euler's equations in double precision at high order.
#pragma once

#include "shared/math/types.h"

namespace zoned::scenario {

/// Counts how often the sign of one component of the body-frame angular velocity changes within
/// `seconds`, for principal moments `inertia` (kg m2) and the start `omega` (rad/s, body axes).
/// Classical Runge-Kutta of order four at 100 microseconds: far below the error of any engine.
struct SpinReference {
    int flips = 0;  ///< sign changes of omega.y
    Vec3d omega_end = Vec3d::Zero();
    double energy_drift = 0.0;  ///< relative, of the reference itself
};

SpinReference free_spin(const Vec3d& inertia, const Vec3d& omega, double seconds);

}  // namespace zoned::scenario
