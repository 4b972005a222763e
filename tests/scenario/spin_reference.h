// SpinReference: a free spin by Euler's equations in double precision at high order.
#pragma once

#include "shared/math/types.h"

namespace zoned::scenario {

struct SpinReference {
    int flips = 0;            ///< sign changes of omega.y
    double interval_s = 0.0;  ///< mean time between them; 0 below two flips
    Vec3d omega_end = Vec3d::Zero();
    double energy_drift = 0.0;  ///< relative, of the reference itself
};

/// Follows the body-frame angular velocity for `seconds` from `omega` (rad/s, body axes), for
/// principal moments `inertia` (kg m2). Classical Runge-Kutta of order four at 100 microseconds:
/// far below the error of any engine.
SpinReference free_spin(const Vec3d& inertia, const Vec3d& omega, double seconds);

/// Counts sign changes of a value that is sampled over time.
class FlipCounter {
  public:
    /// `value` at the time `t`, s; times ascend.
    void add(double t, double value);

    [[nodiscard]] int flips() const { return flips_; }

    /// Mean time between flips, with flips placed between samples by a straight line, s.
    [[nodiscard]] double interval_s() const;

  private:
    bool started_ = false;
    double t_ = 0.0;
    double value_ = 0.0;
    int flips_ = 0;
    double first_ = 0.0;
    double last_ = 0.0;
};

}  // namespace zoned::scenario
