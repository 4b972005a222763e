// turn_rate: the angular velocity between two orientations.
#pragma once

#include "shared/core/elementary/elementary.h"
#include "shared/math/types.h"

namespace zoned {

/// The angular velocity, rad/s in the axes of the world, that turns `from` into `to` within `dt` s,
/// by the shorter rotation.
inline Vec3 turn_rate(const Quat& from, const Quat& to, float dt) {
    Quat turn = to * from.conjugate();
    if (turn.w() < 0.0F) {
        turn.coeffs() = -turn.coeffs();
    }
    const float sine = turn.vec().norm();
    return sine > 0.0F ? Vec3(turn.vec() * (2.0F * elementary::atan2(sine, turn.w()) / sine / dt))
                       : Vec3(Vec3::Zero());
}

}  // namespace zoned
