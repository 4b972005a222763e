// LaneBody: one body of each of eight constraints, as the wide solver computes with it.
#pragma once

#include "server/physics/simd/lanes.h"

namespace zoned::physics {

/// `Tables` has the rows `motion`, `drift` and `tensor` of SolverBodies.
struct LaneBody {
    Lanes3 velocity, spin;
    Lanes inv_mass{};
    Lanes3 shift, turn;
    LanesTensor inverse;  ///< of inertia

    template <class Tables>
    [[gnu::always_inline]] inline LaneBody(const Tables& bodies, const LaneRows& slots) {
        const Block8 motion = gather(bodies.motion.data(), slots);
        velocity = {motion.row[0], motion.row[1], motion.row[2]};
        inv_mass = motion.row[3];
        spin = {motion.row[4], motion.row[5], motion.row[6]};
        const Block8 drift = gather(bodies.drift.data(), slots);
        shift = {drift.row[0], drift.row[1], drift.row[2]};
        turn = {drift.row[4], drift.row[5], drift.row[6]};
        const Block8 tensor = gather(bodies.tensor.data(), slots);
        inverse = {tensor.row[0],
                   tensor.row[1],
                   tensor.row[2],
                   tensor.row[3],
                   tensor.row[4],
                   tensor.row[5]};
    }

    /// Writes the motion back of bodies that impulses move.
    template <class Tables>
    [[gnu::always_inline]] inline void store(Tables& bodies, const LaneRows& slots) const {
        Block8 motion{
            {velocity.x, velocity.y, velocity.z, inv_mass, spin.x, spin.y, spin.z, lanes(0.0F)}};
        transpose(motion);
        ZONED_UNROLL
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            if (motion.row[lane][3] > 0.0F) {
                bodies.motion[slots[lane]].at = motion.row[lane];
            }
        }
    }

    /// Takes an impulse and its moment about the body's centre.
    [[gnu::always_inline]] inline void push(const Lanes3& impulse, const Lanes3& moment) {
        velocity = velocity + inv_mass * impulse;
        spin = spin + inverse * moment;
    }

    /// Takes the opposite.
    [[gnu::always_inline]] inline void pull(const Lanes3& impulse, const Lanes3& moment) {
        velocity = velocity - inv_mass * impulse;
        spin = spin - inverse * moment;
    }
};

}  // namespace zoned::physics
