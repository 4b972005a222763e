// turn_rate: the angular velocity between two orientations.
#pragma once

#include "shared/math/types.h"

namespace zoned {

/// The angular velocity, rad/s in the axes of the world, that turns `from` into `to` within `dt` s,
/// by the shorter rotation.
inline Vec3 turn_rate(const Quat& from, const Quat& to, float dt) {
    Eigen::AngleAxisf turn(Eigen::Quaternionf((to * from.conjugate()).coeffs()));
    if (turn.angle() > static_cast<float>(EIGEN_PI)) {
        turn.angle() -= 2.0F * static_cast<float>(EIGEN_PI);
    }
    return turn.axis() * (turn.angle() / dt);
}

}  // namespace zoned
