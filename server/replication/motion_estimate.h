// MotionEstimate: estimates from the last ticks of an entity whether it falls and whether its
// acceleration turns.
#pragma once

#include "shared/core/ids.h"
#include "shared/motion/kinematic_state.h"

#include <array>

namespace zoned::replication {

/// One per entity, whatever the levels of detail; a few additions per tick for an entity that does
/// not accelerate.
class MotionEstimate {
  public:
    /// Velocities are compared over windows of so many ticks: an eighth of a second at 30 Hz.
    static constexpr int kWindow = 4;

    struct EstimateSettings {
        float tick_s = 1.0F / 30.0F;
        float gravity_mps2 = kGravity;
        float least_mps2 = 0.1F;  ///< accelerations below this are not looked at
    };

    /// One tick of truth. Observations must be consecutive; after a gap, or across a discontinuity,
    /// everything begins anew.
    void observe(Tick now,
                 Tick discontinuity_tick,
                 const motion::KinematicState& truth,
                 const EstimateSettings& settings);

    /// It rests: nothing is known of its future motion.
    void rest() {
        if (tick_ >= 0) {
            *this = MotionEstimate();
        }
    }

    /// The correction from the velocity of the newest tick to that of the parabola through the last
    /// positions, m/s. Semi-implicit Euler moves with the velocity at the end of a step of length
    /// h. An accelerating entity then goes a h / 2 farther per second than p + v t + a t^2 / 2
    /// says: 5 cm after a third of a second of free fall at 30 Hz. Zero where nothing accelerates.
    [[nodiscard]] const Vec3& centring() const { return centring_; }

    /// It accelerates as gravity alone does.
    [[nodiscard]] bool falls() const { return falls_; }

    /// Its acceleration turns steadily, as `acceleration` and `turn` give it (else both are zero).
    /// The velocities of three ticks, kWindow apart, give two differences: mean accelerations over
    /// neighbouring windows. If the acceleration turns at a constant rate w, they differ by a turn
    /// of w times the window. A constant velocity added (a centre that drifts) changes nothing.
    /// Each is shorter than the acceleration at the middle of its window by sin(x) / x, x half that
    /// angle.
    [[nodiscard]] bool turns() const { return turns_; }

    [[nodiscard]] const Vec3& acceleration() const { return acceleration_; }  ///< m/s2, now

    [[nodiscard]] const Vec3& turn() const { return turn_; }  ///< rad/s

    template <class Archive>
    void serialize(Archive& archive) {
        archive(velocities_, position_, centring_, acceleration_, turn_, tick_, known_);
        archive(falls_, turns_);
    }

  private:
    void find_turn(const EstimateSettings& settings);

    static constexpr int kKept = 2 * kWindow + 1;
    std::array<Vec3, kKept> velocities_;  // of tick t at t modulo kKept
    Vec3 position_ = Vec3::Zero();        // of the newest tick
    Vec3 centring_ = Vec3::Zero();
    Vec3 acceleration_ = Vec3::Zero();
    Vec3 turn_ = Vec3::Zero();
    Tick tick_ = -1;
    int known_ = 0;  // consecutive velocities
    bool falls_ = false;
    bool turns_ = false;
};

}  // namespace zoned::replication
