// The nine dead reckoning algorithms of Distributed Interactive Simulation, for those who speak it.
#pragma once

#include "shared/math/types.h"

#include <cstdint>

namespace zoned::motion {

/// Names by three letters: rotation fixed or rotating, position or velocity held constant in its
/// rate, world or body axes. The numbers are those of the field "dead reckoning algorithm".
/// Source: IEEE 1278.1-2012, annex E and table 35 (SISO-REF-010, [UID 44]).
enum class DisAlgorithm : std::uint8_t {
    kStatic = 1,  ///< neither moves nor turns
    kFpw = 2,     ///< constant velocity, does not turn
    kRpw = 3,     ///< constant velocity, turns
    kRvw = 4,     ///< constant acceleration, turns
    kFvw = 5,     ///< constant acceleration, does not turn
    kFpb = 6,     ///< velocity constant along the body's axes, which do not turn
    kRpb = 7,     ///< velocity constant along the body's axes, which turn
    kRvb = 8,     ///< acceleration constant along the body's axes, which turn
    kFvb = 9,     ///< acceleration constant along the body's axes, which do not turn
};

/// What an entity state says of motion. In the body algorithms (kFpb..kFvb) velocity and
/// acceleration are in body axes and the acceleration is the rate of the body-axes velocity, so
/// that the velocity after t is v + a t along the axes of then; in the others both are in world
/// axes. The rate of turn is in body axes for all of them, as the standard has it.
struct DisState {
    Vec3d position = Vec3d::Zero();                                   ///< world, m
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< body to world, unit
    Vec3d velocity = Vec3d::Zero();                                   ///< m/s
    Vec3d acceleration = Vec3d::Zero();                               ///< m/s2
    Vec3d angular_velocity = Vec3d::Zero();                           ///< body axes, rad/s
};

/// Position and orientation `elapsed_s` (>= 0) after `from`; velocity likewise, in the axes of the
/// algorithm. World axes: p + v t + a t^2 / 2. Body axes: p + R (R1 v + R2 a) with R1 and R2 the
/// integrals of exp(w s) and s exp(w s), see turn_integrals.h. Source: IEEE 1278.1-2012, annex E.
DisState dis_predict(const DisState& from, DisAlgorithm algorithm, double elapsed_s);

}  // namespace zoned::motion
