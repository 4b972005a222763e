#include "server/replication/motion_estimate.h"

#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>

namespace zoned::replication {

namespace {

// Free fall differs from resting, sliding and walking by far less than this share of gravity. Drag
// that takes more of it makes order 2 the better guess.
constexpr float kFallingShare = 0.05F;
// The two accelerations that are compared may differ by this factor, squared: an eighth of a circle
// that is not one is none.
constexpr float kSteadySquared = 1.5F;
// Beyond it, per window, a turn looks like one in the opposite direction, rad.
constexpr float kLargestTurn = 2.0F;
// Below it, per window, an acceleration is as good as constant, rad.
constexpr float kLeastTurn = 0.02F;

}  // namespace

void MotionEstimate::observe(Tick now,
                             Tick discontinuity_tick,
                             const motion::KinematicState& truth,
                             const EstimateSettings& settings) {
    if (tick_ != now - 1 || discontinuity_tick >= now) {
        known_ = 0;
    }
    const Vec3 before = velocities_[static_cast<std::size_t>((now + kKept - 1) % kKept)];
    const Vec3 change = truth.velocity - before;
    centring_.setZero();
    falls_ = false;
    turns_ = false;
    if (known_ > 0 && change != Vec3::Zero()) {
        // The displacement beyond the mean of both velocities. If it exceeds what the change of
        // velocity explains, it is a push or a contact and not a matter of integration.
        const Vec3 mean = before + 0.5F * change;
        const Vec3 rest = (truth.position - position_) / settings.tick_s - mean;
        if (rest.squaredNorm() <= 0.2501F * change.squaredNorm()) {
            centring_ = rest;
        }
        const Vec3 pull(0.0F, -settings.gravity_mps2 * settings.tick_s, 0.0F);
        falls_ = (change - pull).squaredNorm() < kFallingShare * kFallingShare * pull.squaredNorm();
    }
    position_ = truth.position;
    velocities_[static_cast<std::size_t>(now % kKept)] = truth.velocity;
    tick_ = now;
    known_ = std::min(known_ + 1, kKept);
    if (known_ == kKept) {
        find_turn(settings);
    }
}

void MotionEstimate::find_turn(const EstimateSettings& settings) {
    const Vec3& last = velocities_[static_cast<std::size_t>(tick_ % kKept)];
    const Vec3& middle = velocities_[static_cast<std::size_t>((tick_ + kKept - kWindow) % kKept)];
    const Vec3& first = velocities_[static_cast<std::size_t>((tick_ + 1) % kKept)];
    const float window_s = static_cast<float>(kWindow) * settings.tick_s;
    const Vec3 later = last - middle;
    const float least = settings.least_mps2 * window_s;
    const float later_squared = later.squaredNorm();
    if (!(later_squared > least * least)) {
        return;
    }
    const Vec3 earlier = middle - first;
    const float earlier_squared = earlier.squaredNorm();
    if (later_squared > kSteadySquared * earlier_squared ||
        earlier_squared > kSteadySquared * later_squared) {
        return;
    }
    const Vec3 across = earlier.cross(later);
    const float sine = across.norm();
    const float angle = elementary::atan2(sine, earlier.dot(later));
    if (!(angle > kLeastTurn && angle < kLargestTurn)) {
        return;
    }
    turns_ = true;
    const Vec3 axis = across / sine;
    turn_ = axis * (angle / window_s);
    const float half = 0.5F * angle;
    // From the middle of the later window to its end, about an axis that `later` is across.
    const auto [half_sine, half_cosine] = elementary::sincos(half);
    acceleration_ =
        (later * half_cosine + axis.cross(later) * half_sine) * (half / half_sine / window_s);
}

}  // namespace zoned::replication
