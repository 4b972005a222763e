// Volatility: finds the kind of prediction that would have needed the fewest publications lately.
#pragma once

#include "server/replication/motion_estimate.h"
#include "server/replication/replication_settings.h"
#include "server/world/entity_type.h"
#include "shared/motion/dead_reckoning.h"
#include "shared/motion/kinematic_state.h"

#include <array>

namespace zoned::replication {

/// An entity at one tick, as kinds of prediction start from it.
struct Truth {
    motion::KinematicState state;  ///< where and how it is; its velocity is the centred one
    const MotionEstimate* estimate = nullptr;
    const world::EntityType* type = nullptr;
};

/// The publication of `truth` in this kind. kTurning takes the acceleration of the estimate and not
/// that of the last tick. kBallistic takes gravity down to the landing point, which this function
/// finds.
motion::KinematicState start_of(const Truth& truth,
                                motion::PredictorOrder order,
                                const ReplicationSettings& settings);

/// Whether an entity moves as the kind supposes: a ballistic one falls, a turning one turns; the
/// orders suit every motion.
bool suits(const MotionEstimate& estimate, motion::PredictorOrder order);

/// The substitute for a kind that does not suit the entity now: order 1 for an entity that does not
/// fall, order 2 for one that does not turn.
motion::PredictorOrder fitting(const MotionEstimate& estimate, motion::PredictorOrder order);

/// Runs, beside the one real stream, a private publication process per kind: each starts again from
/// (quantised) truth whenever its own prediction leaves the bound, and pays for that. The payments
/// decay, so the cheapest kind is the least volatile of the last seconds. A kind that does not suit
/// the entity has no process and costs a multiplication per tick; it enters on a par with the best.
class Volatility {
  public:
    /// Forgets everything; all orders predict from `truth`.
    void restart(Tick now, const motion::KinematicState& truth);

    /// One tick of truth; `quantization` is that of the level of detail.
    void observe(Tick now,
                 const Truth& truth,
                 bool upright,
                 const LodBound& bound,
                 const wire::Quantization& quantization,
                 const ReplicationSettings& settings);

    /// The least volatile of those that suit the entity.
    [[nodiscard]] motion::PredictorOrder best() const { return best_; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(processes_, best_);
    }

  private:
    struct Process {
        motion::KinematicState from;
        Tick tick = 0;
        float cost = 0.0F;
        bool live = false;
    };

    void begin(Process& process,
               Tick now,
               const Truth& truth,
               motion::PredictorOrder order,
               bool upright,
               const wire::Quantization& quantization,
               const ReplicationSettings& settings);
    void choose(const MotionEstimate& estimate);

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
