// Convergence: how a displayed state is led from what was shown to what is predicted, without a
// jump.
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
};

/// Smooths one entity. `begin` is called when a new publication changes the prediction, `display`
/// for every frame.
class Convergence {
  public:
    /// `shown` is what was displayed at this moment (position, velocity), `period_s` >= 0 how long
    /// blending takes.
    void begin(const KinematicState& shown, float period_s);

    /// What to display: `predicted` is the prediction for now from the newest publication, as
    /// predict() returns it (so that it describes its own motion: blending needs where it was at
    /// begin()), `elapsed_s` the time since begin(). Equal to `predicted` from period_s on.
    /// Velocity and angular velocity are those of the displayed motion.
    [[nodiscard]] KinematicState display(ConvergenceMethod method,
                                         const KinematicState& predicted,
                                         float elapsed_s) const;

    /// Upper bound of |displayed - predicted| in metres at `elapsed_s`: the jump that begin()
    /// absorbed, falling as the method declares. `jump_m` is |shown - predicted| at begin, in
    /// position; `velocity_jump_mps` the same in velocity, which only kProjectiveVelocity takes
    /// over: there the bound holds only when it is given.
    [[nodiscard]] static float owed(ConvergenceMethod method,
                                    float jump_m,
                                    float elapsed_s,
                                    float period_s,
                                    float velocity_jump_mps = 0.0F);

  private:
    KinematicState shown_;
    float period_s_ = 0.0F;
};

}  // namespace zoned::motion
