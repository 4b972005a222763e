// Cost table: the measured costs of methods, in ns; the one table from which choices are made.
#pragma once

#include "server/physics/integrator/integrator_kind.h"
#include "server/physics/particles/particle_system.h"
#include "server/physics/soft/soft_def.h"

#include <array>
#include <cstddef>

namespace zoned::physics::method_selection {

// Measured by `zoned-bench integrators soft --scene free_flight,substeps` on one core of an AMD Zen
// 5 (x86-64-v3, g++ 12, -O2), medians of three runs. The same command prints its measurements
// beside these figures. Choices compare these figures with each other alone.

/// Of a piece of free flight of one body, by IntegratorKind.
inline constexpr std::array<double, kIntegratorKinds.size()>
    kFlightPiece_ns{6.2, 6.4, 190.0, 6.4, 6.9, 6.8, 6.6, 21.0, 107.0};

constexpr double flight_cost_ns(IntegratorKind kind, int pieces) {
    return kFlightPiece_ns[static_cast<std::size_t>(kind)] * pieces;
}

/// The cost of a piece of a particle's flight over the ground, by its further surroundings. From
/// `zoned-bench kernels --scene surroundings` on the same core: 1.0 to 1.4 ns on the ground alone,
/// 2.1 to 2.4 with drag, 8.7 to 8.9 with gusts, 43 to 44 with 8 balls, 80 to 82 with 16 and a
/// heightfield.
struct ParticleCost {
    static constexpr double kGround_ns = 1.0;
    static constexpr double kDrag_ns = 1.1;
    static constexpr double kGusts_ns = 6.8;  ///< beside drag
    static constexpr double kBall_ns = 4.3;   ///< each that may be met
    static constexpr double kField_ns = 4.0;  ///< a heightfield
    /// An animal of a flock instead of all this, with 45 others tested (`zoned-bench crowd --scene
    /// flock_50k`).
    static constexpr double kFlock_ns = 97.0;
};

/// A step of one particle of a system in so many pieces, but for balls and fields, which the zone
/// adds.
double particle_cost_ns(const ParticleSystemDef& def, int pieces);

/// By how much of its diameter a prop that is one hull far away was off at most, of 64 that were
/// thrown, after 5 s: tables, as one hull for their parts; jellies, as rigid hulls (ropes: 0.2).
/// `zoned-bench representation` prints its own as error_max_share.
inline constexpr double kSingleErrorShare = 0.08;
inline constexpr double kSoftHullErrorShare = 0.7;

/// The cost of one sweep over a soft body, by its parts.
struct SweepCost {
    double node_ns = 0.0;
    double spring_ns = 0.0;
    double tetrahedron_ns = 0.0;
    double face_ns = 0.0;  ///< of those that hold gas
};

/// Numbers of each.
struct SweepCounts {
    double nodes = 0.0;
    double springs = 0.0;
    double tetrahedra = 0.0;
    double faces = 0.0;
};

constexpr double sweep_cost_ns(const SweepCost& cost, const SweepCounts& counts) {
    return cost.node_ns * counts.nodes + cost.spring_ns * counts.springs +
           cost.tetrahedron_ns * counts.tetrahedra + cost.face_ns * counts.faces;
}

inline constexpr SweepCost kXpbdSubstep{2.9, 1.9, 47.0, 8.4};
/// With the bound on substeps that bodies with volumes look up once a step.
inline constexpr SweepCost kSemiImplicitSubstep{4.9, 1.5, 37.0, 7.8};
inline constexpr SweepCost kNewtonStep{14.0, 22.0, 88.0, 17.0};  ///< without its passes
inline constexpr SweepCost kGradientPass{8.8, 3.2, 8.4, 1.3};

SweepCounts counts_of(const soft::SoftDef& def);

/// Of a tick with so many substeps; implicit Euler's with so many Newton steps and passes in all.
double soft_cost_ns(soft::SoftMethod method,
                    const SweepCounts& counts,
                    double substeps,
                    double newton_steps,
                    double gradient_passes);

}  // namespace zoned::physics::method_selection
