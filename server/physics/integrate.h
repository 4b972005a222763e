// Integration of free motion: velocities, positions, orientations.
#pragma once

#include "shared/math/types.h"

#include <cmath>

namespace zoned::physics {

/// The rotation by the vector `turn` (rad, world axes) applied after `q`, renormalised. Exact for
/// any angle: half the angle's sine and cosine by series when it is small, by libm otherwise.
inline Quat turned(const Quat& q, const Vec3& turn) {
    const float half2 = 0.25F * turn.squaredNorm();
    float sinc = 0.0F;  // sin(x) / x with x the half angle
    float cosine = 0.0F;
    if (half2 < 0.06F) {
        // Truncation is below x^8 / 40320 < 4e-10, far under a float's last bit.
        sinc = 1.0F + half2 * (-1.0F / 6.0F + half2 * (1.0F / 120.0F - half2 / 5040.0F));
        cosine = 1.0F + half2 * (-0.5F + half2 * (1.0F / 24.0F - half2 / 720.0F));
    } else {
        const float half = std::sqrt(half2);
        sinc = std::sin(half) / half;
        cosine = std::cos(half);
    }
    const Vec3 s = 0.5F * sinc * turn;
    const Quat step(cosine, s.x(), s.y(), s.z());
    Quat out = step * q;
    out.coeffs() *= 1.0F / out.coeffs().norm();
    return out;
}

/// Free rotation of a rigid body over h seconds by the midpoint rule on the orientation with the
/// angular momentum held: the momentum is exact (to rounding), the spin is bounded by |L| over the
/// smallest moment whatever the step, and the error in energy is of second order and does not
/// accumulate. Semi-implicit Euler with an explicit gyroscopic term would gain energy without
/// bound. In and out: orientation, rotation matrix, spin (rad/s, world). Returns the turn, rad.
inline Vec3 rotate_freely(const Vec3& moments,
                          const Vec3& inverse_moments,
                          float h,
                          Quat& orientation,
                          Mat3& rotation,
                          Vec3& spin) {
    const Vec3 momentum = rotation * moments.cwiseProduct(rotation.transpose() * spin);
    const auto spin_at = [&](const Mat3& r) -> Vec3 {
        return r * inverse_moments.cwiseProduct(r.transpose() * momentum);
    };
    const Mat3 halfway = turned(orientation, 0.5F * h * spin).toRotationMatrix();
    const Vec3 turn = h * spin_at(halfway);
    orientation = turned(orientation, turn);
    rotation = orientation.toRotationMatrix();
    spin = spin_at(rotation);
    return turn;
}

}  // namespace zoned::physics
