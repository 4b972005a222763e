// Whether truth leaves what clients predict from: the newest publication, and those before it that
// some of them may still display.
#include "server/replication/stream_table.h"

namespace zoned::replication {

namespace {

/// The promise lets a subscriber be wrong by dv_max times the age of its update. So a prediction
/// must not be wrong by more than dv_max in velocity, even while its position is still within the
/// bound. The same holds for its rate of turn. Order 0 predicts neither.
bool leaves_velocity(const Stream& stream,
                     float elapsed_s,
                     const motion::KinematicState& truth,
                     float allowed_mps,
                     float allowed_rps) {
    if (stream.state.order == motion::PredictorOrder::kStatic) {
        return false;
    }
    const Vec3 predicted = motion::predict_velocity(stream.from, stream.state.order, elapsed_s);
    // A prediction that has come to rest turns no more.
    const Vec3 spin = predicted == Vec3::Zero() ? predicted : stream.from.angular_velocity;
    const float apart_rps = stream.upright ? 0.0F : (spin - truth.angular_velocity).norm();
    return (predicted - truth.velocity).norm() > allowed_mps || apart_rps > allowed_rps;
}

}  // namespace

bool StreamTable::note_breach(Stream& stream,
                              Tick now,
                              const motion::KinematicState& truth,
                              const world::EntityType& type) {
    const LodBound& bound = settings_.lods[stream.lod];
    const float elapsed = elapsed_seconds(stream.tick, now, settings_.tick_s);
    // A step of quantisation on top: rounding alone must never cause an update.
    const float allowed_mps =
        type.max_velocity_jump_mps + quantization_[stream.lod].velocity_step_mps;
    const float allowed_rps =
        type.max_spin_jump_rps() + quantization_[stream.lod].angular_velocity_step_rps;
    const bool breach = leaves_bound(stream.from, stream.state.order, elapsed, truth, bound) ||
                        leaves_velocity(stream, elapsed, truth, allowed_mps, allowed_rps);
    if (breach || leaves_watched(stream, now, truth, bound)) {
        stream.breach_tick = now;
    }
    return breach;
}

bool StreamTable::leaves_watched(Stream& stream,
                                 Tick now,
                                 const motion::KinematicState& truth,
                                 const LodBound& bound) const {
    bool leaves = false;
    if (stream.watched_until <= now) {
        return leaves;
    }
    for (Past& old : stream.past) {
        const float elapsed = elapsed_seconds(old.tick, now, settings_.tick_s);
        if (old.watched_until > now && leaves_bound(old.from, old.order, elapsed, truth, bound)) {
            old.watched_until = 0;
            leaves = true;
        }
    }
    return leaves;
}

}  // namespace zoned::replication
