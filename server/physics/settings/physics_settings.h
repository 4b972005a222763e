// PhysicsSettings: the config of a zone's rigid bodies.
#pragma once

#include "server/physics/integrator/integrator_kind.h"
#include "server/physics/settings/variant_settings.h"
#include "server/spatial/broadphase_kind.h"
#include "shared/math/types.h"

#include <cstdint>

namespace zoned::physics {

using spatial::BroadphaseKind;

struct PhysicsSettings {
    Vec3 gravity = Vec3(0.0F, -kGravity, 0.0F);  ///< m/s2
    /// 0: each island gets as many as its loads ask for within the error budget; 1..64: this many.
    int substeps = 0;
    /// The distance by which a contact may yield to its load, m: `substeps` 0 goes by it. A contact
    /// that carries the same load for seconds yields by far less.
    float error_budget_m = 0.005F;
    int velocity_iterations = 1;    ///< per substep, 1..64
    float sleep_speed_mps = 0.05F;  ///< a body slower than this ...
    float sleep_spin_rps = 0.05F;   ///< ... in both senses ...
    float sleep_after_s =
        0.5F;  ///< ... for this long may sleep, once its whole island may; 0 = sleeping off
    /// Which structure finds the pairs of bodies; the results are the same for all.
    BroadphaseKind broadphase = BroadphaseKind::kAutomatic;
    float cell_m = 4.0F;      ///< grid: cell size of one level; the others are doublings of it
    int cell_depth = 16;      ///< octree, quadtree: levels below the root, 1..30
    int boxes_per_cell = 16;  ///< octree, quadtree: a cell with more of them splits, 1..1000
    /// While there are so many pairs (about 0.5 kB each), no new pairs of dynamic bodies are looked
    /// for. From twice as many on no others are either: those with the highest ids wait.
    std::uint32_t max_pairs = 1U << 18;
    int relax_iterations = 1;            ///< per substep, without the contact springs, 1..64
    float restitution_speed_mps = 0.5F;  ///< slower impacts do not bounce
    float event_impulse_ns = 1000.0F;    ///< contacts that carry more are events in each step
    SolverVariant method = SolverVariant::kSoftStep;  ///< solves contacts and joints
    VariantSettings methods;                          ///< of all methods but kSoftStep
    /// The method that moves the centre of mass of dynamic bodies while neither contact nor joint
    /// holds them; the solver's substeps move the others, and rotation keeps its own method
    /// (rotate_freely), whatever is chosen. All but kVerlet, see why_unfit_integrator.
    IntegratorKind body_integrator = IntegratorKind::kDefault;
    /// The same for particles until they meet a surface. The default moves them for the rest of
    /// that step, and moves particles that rest on something.
    IntegratorKind particle_integrator = IntegratorKind::kDefault;
    /// Free flight is cut into so many equal pieces a step, 1..kMostFlightPieces.
    int body_flight_pieces = 1;
    int particle_flight_pieces = 1;
};

}  // namespace zoned::physics
