// KinematicState: the motion of an entity at one tick; dead reckoning starts from it.
#pragma once

#include "shared/math/types.h"

#include <limits>

namespace zoned::motion {

/// Coordinates are zone-local metres unless the owner of the value says otherwise.
struct KinematicState {
    Vec3 position = Vec3::Zero();          ///< centre of mass, m
    Quat orientation = Quat::Identity();   ///< body to world, unit length
    Vec3 velocity = Vec3::Zero();          ///< m/s
    Vec3 acceleration = Vec3::Zero();      ///< m/s2, used above predictor order 1 only
    Vec3 angular_velocity = Vec3::Zero();  ///< rad/s, world axes
    Vec3 turn = Vec3::Zero();  ///< at which the acceleration turns, rad/s, world axes: kTurning
    /// A falling entity comes to rest where its centre is at this height, m: kBallistic.
    float floor = -std::numeric_limits<float>::infinity();
};

}  // namespace zoned::motion
