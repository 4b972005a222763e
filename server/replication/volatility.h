// Volatility: which predictor order would have needed the fewest publications lately.
#pragma once

#include "server/replication/replicator.h"
#include "shared/motion/dead_reckoning.h"
#include "shared/motion/kinematic_state.h"

#include <array>

namespace zoned::replication {

/// Runs, beside the one real stream, a private publication process per predictor order: each starts
/// again from (quantised) truth whenever its own prediction leaves the bound, and pays for that.
/// The payments decay, so the cheapest order is the least volatile of the last seconds.
class Volatility {
  public:
    /// Forgets everything; all orders predict from `truth`.
    void restart(Tick now, const motion::KinematicState& truth);

    /// One tick of truth.
    void observe(Tick now,
                 const motion::KinematicState& truth,
                 bool upright,
                 const LodBound& bound,
                 const Settings& settings);

    [[nodiscard]] motion::PredictorOrder best() const { return best_; }

  private:
    struct Process {
        motion::KinematicState from;
        Tick tick = 0;
        float cost = 0.0F;
    };

    void choose();

    std::array<Process, motion::kPredictorOrders> processes_;
    motion::PredictorOrder best_ = motion::PredictorOrder::kLinear;
};

/// True when `truth` is farther from the prediction than the bound, in position or in orientation.
bool leaves_bound(const motion::KinematicState& from,
                  motion::PredictorOrder order,
                  float elapsed_s,
                  const motion::KinematicState& truth,
                  const LodBound& bound);

/// Seconds that clients extrapolate from a publication at `from` to `now`; computed as they do.
float elapsed_seconds(Tick from, Tick now, float tick_s);

}  // namespace zoned::replication
