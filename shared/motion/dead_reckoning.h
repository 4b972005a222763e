// Dead reckoning: the predictor that server and client run alike (orders 0, 1 and 2).
#pragma once

#include "shared/motion/kinematic_state.h"

#include <cstdint>

namespace zoned::motion {

/// How position is extrapolated; orientation turns with constant angular velocity for orders 1
/// and 2.
enum class PredictorOrder : std::uint8_t {
    kStatic = 0,     ///< stays where it was
    kLinear = 1,     ///< constant velocity
    kQuadratic = 2,  ///< constant acceleration
};

inline constexpr int kPredictorOrders = 3;

/// The state `elapsed_s` (>= 0, s) after `from`: p + v t + a t^2 / 2; q turned by |w| t about w.
/// The result describes its own further motion: what the order does not use (the acceleration below
/// order 2, all rates for order 0) is zero in it. Source: IEEE 1278.1-2012, annex E (dead reckoning
/// in world coordinates).
KinematicState predict(const KinematicState& from, PredictorOrder order, float elapsed_s);

/// Only the position part of predict(): what the server's error test needs every tick.
Vec3 predict_position(const KinematicState& from, PredictorOrder order, float elapsed_s);

/// Only the orientation part of predict().
Quat predict_orientation(const KinematicState& from, PredictorOrder order, float elapsed_s);

/// Angle between two orientations, rad, 0..pi.
float angle_between(const Quat& a, const Quat& b);

}  // namespace zoned::motion
