// Integration of free motion: velocities, positions, orientations.
#pragma once

#include "shared/core/elementary/elementary.h"
#include "shared/math/types.h"

#include <cmath>

namespace zoned::physics {

/// The rotation by the vector `turn` (rad, world axes) applied after `q`, renormalised. Exact for
/// any angle: half the angle's sine and cosine by series when it is small.
template <class Real, int kOptions>
Eigen::Quaternion<Real, kOptions> turned(const Eigen::Quaternion<Real, kOptions>& q,
                                         const Eigen::Matrix<Real, 3, 1>& turn) {
    const Real half2 = Real(0.25) * turn.squaredNorm();
    Real sinc = 0;  // sin(x) / x with x the half angle
    Real cosine = 0;
    if (half2 < Real(0.06)) {
        // Truncation is below x^8 / 40320 < 4e-10, far under a float's last bit.
        sinc = 1 + half2 * (Real(-1.0 / 6) + half2 * (Real(1.0 / 120) - half2 * Real(1.0 / 5040)));
        cosine = 1 + half2 * (Real(-0.5) + half2 * (Real(1.0 / 24) - half2 * Real(1.0 / 720)));
    } else {
        const Real half = std::sqrt(half2);
        const auto both = elementary::sincos(half);
        sinc = both.sine / half;
        cosine = both.cosine;
    }
    const Eigen::Matrix<Real, 3, 1> s = Real(0.5) * sinc * turn;
    const Eigen::Quaternion<Real, kOptions> step(cosine, s.x(), s.y(), s.z());
    Eigen::Quaternion<Real, kOptions> out = step * q;
    out.coeffs() *= 1 / out.coeffs().norm();
    return out;
}

/// Free rotation of a rigid body over h seconds. The kinetic energy is a sum of three terms, one
/// per principal axis, and the motion of each alone is a plain rotation about that axis; they are
/// composed symmetrically (Dullweber, Leimkuhler, McLachlan, "Symplectic splitting methods for
/// rigid body molecular dynamics", J. Chem. Phys. 107, 1997). Angular momentum is exact, the energy
/// swings by a second-order amount and does not drift, and nothing can blow up; semi-implicit Euler
/// with an explicit gyroscopic term would gain energy without bound. Turns of more than a
/// fiftieth of a radian are cut into several.
///
/// In doubles, because the rounding of a float rotation would enter the momentum several times per
/// call. `h`: s, negative: backwards. In and out: orientation, spin (rad/s, world). Returns the
/// turn, rad, to first order.
Vec3 rotate_freely(const Vec3& moments, float h, Quat& orientation, Vec3& spin);

}  // namespace zoned::physics
