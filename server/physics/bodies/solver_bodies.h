// SolverBodies: the bodies that a solver moves, in rows of eight numbers per body.
#pragma once

#include "server/compute/team.h"
#include "server/physics/bodies/bodies.h"
#include "server/physics/integrator/integrator_kind.h"
#include "server/physics/simd/lanes.h"

#include <cstdint>
#include <vector>

namespace zoned::physics {

/// Slot 0 stands for everything that does not move. All tables have one row per slot.
class SolverBodies {
  public:
    std::vector<Row8> motion;  ///< velocity (m/s), inverse mass, spin (rad/s, world), 0
    /// How far the body went since the step began: shift (m), 0, turn (rad, to first order), 0.
    std::vector<Row8> drift;
    std::vector<Row8> tensor;  ///< inverse inertia, world: xx xy xz yy yz zz; 0, 0

    void reserve(std::size_t bodies);

    /// Takes nobody but slot 0. `h` is the length of a substep, s.
    void begin(const Vec3& gravity, float dt, float h);

    /// The slot of an awake body; it is taken in when it is new.
    std::uint32_t slot_of(Bodies& bodies, std::uint32_t row);

    [[nodiscard]] std::size_t size() const { return row_.size(); }

    [[nodiscard]] std::uint32_t row(std::size_t slot) const { return row_[slot]; }

    [[nodiscard]] bool moved_by_impulses(std::size_t slot) const {
        return motion[slot].at[3] > 0.0F;
    }

    /// Its inertia turns so far within the step that masses have to follow it.
    [[nodiscard]] bool turns_fast(std::size_t slot) const {
        return spinner_of_[slot] != kNoIndex && spinners_[spinner_of_[slot]].fast;
    }

    /// From now on the body's orientation and inertia are followed in each substep.
    void track(const Bodies& bodies, std::uint32_t slot);

    /// Orientation now of a body that stood at `start` when the step began.
    [[nodiscard]] Quat orientation(std::uint32_t slot, const Quat& start) const;

    /// Inverse inertia times a moment, world; zero for a body that impulses do not move.
    [[nodiscard]] Vec3 inverse_times(std::uint32_t slot, const Vec3& moment) const {
        const Lanes& t = tensor[slot].at;
        return {t[0] * moment.x() + t[1] * moment.y() + t[2] * moment.z(),
                t[1] * moment.x() + t[3] * moment.y() + t[4] * moment.z(),
                t[2] * moment.x() + t[4] * moment.y() + t[5] * moment.z()};
    }

    /// Momentum (N s) and angular momentum (N m s) of a motion; zero for a body that impulses do
    /// not move.
    [[nodiscard]] Row8 momentum(std::uint32_t slot, const Row8& of) const;

    /// Gives a body an impulse and a change of spin.
    void change(std::uint32_t slot, const Vec3& impulse, const Vec3& spin);

    /// Begins a substep: gravity changes velocities.
    void integrate_velocities(compute::Team& team);
    /// Moves all on for that long, s.
    void integrate_positions(const Bodies& bodies, float seconds, compute::Team& team);
    /// Ends a substep: moves positions by the mean velocity.
    void follow_mean_velocity(compute::Team& team);

    /// Gives a body an impulse: linear at the centre, N s, and angular, N m s.
    void apply(std::uint32_t slot, const Vec3& impulse, const Vec3& moment);

    /// Motion when the substep began.
    [[nodiscard]] const Row8& start(std::size_t slot) const { return start_[slot]; }

    /// A body that turns fast stands as it will `time` from now, s, if nothing pushes it; negative:
    /// as it did.
    void turn_freely(const Bodies& bodies, std::uint32_t slot, float time);

    /// The motion changed by `change` not at the start of the substep but `time` later, s: until
    /// then the body goes as it went before. One that turns fast stands as it does then, and as it
    /// would have stood at the start afterwards. True: it begins to turn fast.
    bool shift_change(const Bodies& bodies, std::uint32_t slot, const Row8& change, float time);

    /// Writes poses and velocities of the bodies back that impulses move. A body whose result is
    /// not finite or out of range keeps its pose, stops, and is appended to `broken`.
    void store(Bodies& bodies, compute::Team& team, std::vector<std::uint32_t>& broken);

    [[nodiscard]] static Vec3 linear(const Row8& row) { return {row.at[0], row.at[1], row.at[2]}; }

    [[nodiscard]] static Vec3 angular(const Row8& row) { return {row.at[4], row.at[5], row.at[6]}; }

  private:
    /// A body that turns so far within a step, or has joints, that its inertia must follow in each
    /// substep.
    struct Spinner {
        std::uint32_t slot = 0;
        Quat orientation = Quat::Identity();
        bool fast = true;  ///< turns far: free rotation is computed with care
    };

    template <class Visit>
    void for_each_slot(compute::Team& team, Visit&& visit);
    void turn(const Bodies& bodies, float seconds, Spinner& spinner);
    enum class StoreOutcome : std::uint8_t {
        kStored,
        kSlowed,  ///< speed or spin was cut to the most there is
        kUnfit,   ///< not finite or out of range
    };

    /// Whether inverse mass and inertia of a body that impulses move are numbers.
    [[nodiscard]] bool sound(std::size_t slot) const;
    [[nodiscard]] StoreOutcome store_body(Bodies& bodies, std::size_t slot) const;

    void take_forces(const Bodies& bodies, std::uint32_t row, std::uint32_t slot);
    void take_spin(const Bodies& bodies, std::uint32_t row, std::uint32_t slot);
    bool begin_to_spin(const Bodies& bodies, std::uint32_t slot, const Vec3& way);
    void set_spin(std::uint32_t slot, const Vec3& spin);
    [[nodiscard]] Mat3 middle_axes(const Bodies& bodies, std::uint32_t row) const;
    void take_tensor(const Bodies& bodies, std::uint32_t row, std::size_t slot, const Mat3& axes);

    Vec3 gravity_ = Vec3::Zero();
    float dt_ = 0.0F;
    float h_ = 0.0F;
    std::vector<Row8> gain_;   // of velocity and spin in a substep, by gravity and forces
    std::vector<Row8> damp_;   // the share left of them after a substep
    std::vector<Row8> start_;  // motion when the substep began
    std::vector<std::uint32_t> row_;
    std::vector<Spinner> spinners_;
    std::vector<std::uint32_t> spinner_of_;  // by slot: place in `spinners_`, or kNoIndex
    std::vector<StoreOutcome> outcome_;      // of each body, by slot
};

/// Turns a body freely, about principal axes that may be tilted against its own; see rotate_freely.
Vec3 rotate_body(const Bodies& bodies,
                 std::uint32_t row,
                 float seconds,
                 Quat& orientation,
                 Vec3& spin);

/// A body that no constraint holds, over dt seconds: its centre by the integrator, which by default
/// is exact under constant acceleration, and free rotation that keeps the angular momentum.
void fly_free(Bodies& bodies,
              std::uint32_t row,
              const Vec3& gravity,
              float dt,
              IntegratorKind integrator,
              int pieces,
              std::vector<std::uint32_t>& broken);

}  // namespace zoned::physics
