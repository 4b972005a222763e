// Integration of free motion: velocities, positions, orientations.
#pragma once

#include "shared/math/types.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

/// The rotation by the vector `turn` (rad, world axes) applied after `q`, renormalised. Exact for
/// any angle: half the angle's sine and cosine by series when it is small, by libm otherwise.
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
        sinc = std::sin(half) / half;
        cosine = std::cos(half);
    }
    const Eigen::Matrix<Real, 3, 1> s = Real(0.5) * sinc * turn;
    const Eigen::Quaternion<Real, kOptions> step(cosine, s.x(), s.y(), s.z());
    Eigen::Quaternion<Real, kOptions> out = step * q;
    out.coeffs() *= 1 / out.coeffs().norm();
    return out;
}

/// Free rotation of a rigid body over h seconds by the midpoint rule on the orientation with the
/// angular momentum held: the momentum is exact (to rounding), the spin is bounded by |L| over the
/// smallest moment whatever the step, and the error in energy is of second order and does not
/// accumulate. Semi-implicit Euler with an explicit gyroscopic term would gain energy without
/// bound. Turns of more than an eighth of a radian are cut into several.
///
/// In doubles, because a float rotation matrix is orthonormal to 1e-7 only, and this error enters
/// the momentum four times per call and always with the same sign.
/// In and out: orientation, spin (rad/s, world). Returns the turn, rad, to first order.
inline Vec3 rotate_freely(const Vec3& moments, float h, Quat& orientation, Vec3& spin) {
    using Quatd = Eigen::Quaternion<double, Eigen::DontAlign>;
    const Vec3d principal = moments.cast<double>();
    const Vec3d inverse = principal.cwiseInverse();
    Quatd q = orientation.cast<double>().normalized();
    Vec3d w = spin.cast<double>();
    const Eigen::Matrix3d start = q.toRotationMatrix();
    const Vec3d momentum = start * principal.cwiseProduct(start.transpose() * w);
    constexpr double kLongestTurn = 0.125;
    constexpr int kMostPieces = 128;
    const auto spin_at = [&](const Quatd& at) -> Vec3d {
        const Eigen::Matrix3d r = at.toRotationMatrix();
        return r * inverse.cwiseProduct(r.transpose() * momentum);
    };
    Vec3d total = Vec3d::Zero();
    double left = h;
    for (int i = 1; left > 0.0; ++i) {
        // A body that tumbles speeds up on the way, so each piece is measured anew.
        const double rate = w.norm();
        const bool last = rate * left <= kLongestTurn || i == kMostPieces;
        const double piece = last ? left : kLongestTurn / rate;
        const Vec3d halfway = 0.5 * piece * w;
        const Vec3d turn = piece * spin_at(turned(q, halfway));
        q = turned(q, turn);
        w = spin_at(q);
        total += turn;
        left = last ? 0.0 : left - piece;
    }
    orientation = q.cast<float>();
    spin = w.cast<float>();
    return total.cast<float>();
}

}  // namespace zoned::physics
