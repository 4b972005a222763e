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
                          ///< Networked Games", 2011)
};

/// Smooths one entity. `begin` is called when a new publication changes the prediction, `display`
/// for every frame.
class Convergence {
  public:
    /// `shown` is what was displayed at this moment (position, velocity), `period_s` >= 0 how long
    /// blending takes.
    void begin(const KinematicState& shown, float period_s);

    /// What to display: `predicted` is the prediction for now from the newest publication,
    /// `elapsed_s` the time since begin(). Equal to `predicted` from period_s on.
    [[nodiscard]] KinematicState display(ConvergenceMethod method,
                                         const KinematicState& predicted,
                                         float elapsed_s) const;

    /// Upper bound of |displayed - predicted| in metres at `elapsed_s`: the jump that begin()
    /// absorbed, falling as the method declares. `jump_m` is |shown - predicted| at begin.
    [[nodiscard]] static float owed(ConvergenceMethod method,
                                    float jump_m,
                                    float elapsed_s,
                                    float period_s);

  private:
    KinematicState shown_;
    float period_s_ = 0.0F;
};

}  // namespace zoned::motion
