// Convergence: leads a displayed state from the shown one to the predicted one without a jump.
#pragma once

#include "shared/motion/kinematic_state.h"

#include <cstdint>

namespace zoned::motion {

enum class ConvergenceMethod : std::uint8_t {
    kSnap,                ///< displays the prediction at once
    kLinear,              ///< the offset to the prediction falls linearly to zero
    kProjectiveVelocity,  ///< projective velocity blending (Murphy, "Believable Dead Reckoning for
                          ///< Networked Games", in Game Engine Gems 2, 2011): starts with the shown
                          ///< velocity, ends with the predicted one. The weight of the prediction
                          ///< is 3 s^2 - 2 s^3 instead of Murphy's s = elapsed / period, which
                          ///< jumps in velocity at both ends.
    kHermite,             ///< the cubic Hermite spline whose position and velocity are the shown
                          ///< ones at the start and the predicted ones at the end: the least jerk
                          ///< of the methods without a kink
};

inline constexpr int kConvergenceMethods = 4;

/// Smooths one entity. `begin` is called when a new publication changes the prediction, `display`
/// for every frame.
class Convergence {
  public:
    /// `shown` is what was displayed at this moment, `predicted` the new prediction for it; their
    /// offset is led to zero, wherever the prediction goes meanwhile. `period_s` >= 0: duration of
    /// the blending.
    void begin(const KinematicState& shown, const KinematicState& predicted, float period_s);

    /// The state to display: `predicted` is the prediction for now, `elapsed_s` the time since
    /// begin(). Equal to `predicted` from period_s on. Velocity and angular velocity are those of
    /// the displayed motion.
    [[nodiscard]] KinematicState display(ConvergenceMethod method,
                                         const KinematicState& predicted,
                                         float elapsed_s) const;

    /// Upper bound of |displayed - predicted| in metres at `elapsed_s`: the jump that begin()
    /// absorbed, falling as the method declares. `jump_m` is |shown - predicted| at begin, in
    /// position; `velocity_jump_mps` the same in velocity, which kProjectiveVelocity and kHermite
    /// take over: there the bound holds only when it is given.
    [[nodiscard]] static float remaining_error(ConvergenceMethod method,
                                               float jump_m,
                                               float elapsed_s,
                                               float period_s,
                                               float velocity_jump_mps = 0.0F);

  private:
    Vec3 jump_ = Vec3::Zero();           // shown - predicted at begin(), m
    Vec3 velocity_jump_ = Vec3::Zero();  // likewise, m/s
    Vec3 axis_ = Vec3::Zero();           // of the shorter rotation from predicted to shown
    float angle_ = 0.0F;                 // of it, rad
    float period_s_ = 0.0F;
};

}  // namespace zoned::motion
