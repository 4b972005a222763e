// Dead reckoning: the predictors that server and client run alike (orders 0, 1 and 2, falling,
// turning).
#pragma once

#include "shared/motion/kinematic_state.h"

#include <cstdint>

namespace zoned::motion {

/// How position is extrapolated; orientation turns with constant angular velocity for all but
/// order 0.
enum class PredictorOrder : std::uint8_t {
    kStatic = 0,     ///< stays where it was
    kLinear = 1,     ///< constant velocity
    kQuadratic = 2,  ///< constant acceleration
    kBallistic = 3,  ///< constant acceleration (that of gravity) down to `floor`, where it rests
    kTurning = 4,    ///< an acceleration of constant magnitude that turns at the constant rate
                     ///< `turn`: circles and helices, also about centres that drift
};

inline constexpr int kPredictorOrders = 5;

/// The state `elapsed_s` (>= 0, s) after `from`. Position: p + v t + a t^2 / 2; kTurning: the twice
/// integrated acceleration R(w t) a, see turn_integrals.h. Orientation: q turned by |w| t about w.
/// The result describes its own further motion: members that the kind does not use (the
/// acceleration below order 2, all rates for order 0 and after landing) is zero in it. Source: IEEE
/// 1278.1-2012, annex E (dead reckoning in world coordinates) for orders 0 to 2; the other two are
/// integrals of the equations of motion.
KinematicState predict(const KinematicState& from, PredictorOrder order, float elapsed_s);

/// Only the position part of predict(); the server's error test needs it every tick.
Vec3 predict_position(const KinematicState& from, PredictorOrder order, float elapsed_s);

/// Only the velocity part of predict().
Vec3 predict_velocity(const KinematicState& from, PredictorOrder order, float elapsed_s);

/// Only the orientation part of predict().
Quat predict_orientation(const KinematicState& from, PredictorOrder order, float elapsed_s);

/// Time until an entity that falls from `from` under its acceleration meets its floor, s (>= 0). It
/// is 0 at or below the floor without a rise, and infinity where it never meets the floor.
float landing_time(const KinematicState& from);

/// Angle between two orientations, rad, 0..pi.
float angle_between(const Quat& a, const Quat& b);

}  // namespace zoned::motion
