// VariantBodies: the bodies that a method moves in a step, from the scene's columns and back.
#pragma once

#include "server/physics/bodies/bodies.h"
#include "server/physics/solver_variants/rows/row_system.h"

#include <cstdint>
#include <vector>

namespace zoned::physics {

/// The motion of a body since the step began. Slot 0 stands for all that does not move.
struct VariantBody {
    std::uint32_t row = kNoIndex;
    Quat orientation = Quat::Identity();
    Vec3d shift = Vec3d::Zero();     ///< since the step began, m
    Vec3d turn = Vec3d::Zero();      ///< rad, to first order
    Vec3d velocity = Vec3d::Zero();  ///< when the substep began, before forces
    Vec3d spin = Vec3d::Zero();
    Vec3d free_velocity = Vec3d::Zero();  ///< after forces, before impulses
    Vec3d free_spin = Vec3d::Zero();
};

/// Slots are those of RowSystem::bodies, which holds the velocities.
class VariantBodies {
  public:
    void reserve(std::size_t bodies) { entries_.reserve(bodies + 1); }

    void begin(const Vec3& gravity, RowSystem& system);
    /// The slot of a body, taken in when it is new; 0 where it is not awake.
    std::uint32_t slot_of(Bodies& bodies, std::uint32_t row, RowSystem& system);

    [[nodiscard]] std::size_t size() const { return entries_.size(); }

    VariantBody& operator[](std::size_t slot) { return entries_[slot]; }

    const VariantBody& operator[](std::size_t slot) const { return entries_[slot]; }

    /// Begins a substep of h: inertia as the bodies stand, velocities change by the forces. Damping
    /// is implicit, v / (1 + c h): stable however strong.
    void gain(const Bodies& bodies, double h, RowSystem& system);
    /// Ends a substep: semi-implicit Euler, x += v h with the new velocity, and the free rotation
    /// of `rotate_freely`. With `mean`, one that no impulse has touched moves with its mean
    /// velocity, which is exact under constant forces.
    void move(const Bodies& bodies, double h, bool mean, RowSystem& system);
    /// Moves the bodies by velocities that are in `push` and leave no trace.
    void displace(double h, const std::vector<RowBody>& push);
    /// Gives slots back and leaves the bodies as they were.
    void release(Bodies& bodies) const;
    /// Gives slots back. A body whose result is not finite or out of range keeps its pose, stops,
    /// and is appended to `broken`.
    void store(Bodies& bodies, const RowSystem& system, std::vector<std::uint32_t>& broken) const;

  private:
    Vec3 gravity_ = Vec3::Zero();
    std::vector<VariantBody> entries_;
};

}  // namespace zoned::physics
