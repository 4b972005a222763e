// Variant settings: the method that solves contacts and joints in a step, and its parameters.
#pragma once

#include <cstdint>

namespace zoned::physics {

/// How contacts and joints are answered. All but the first are described in
/// server/physics/solver_variants; the five that follow it solve one and the same system of rows
/// (row_system.h).
enum class SolverVariant : std::uint8_t {
    kSoftStep,           ///< substeps by load, soft contacts: ContactSolver
    kJacobi,             ///< all rows at once, by mass splitting
    kGaussSeidel,        ///< one row after the other: projected Gauss-Seidel
    kOverRelaxation,     ///< the same with steps that are `omega` times as long
    kConjugateGradient,  ///< Gauss-Seidel as the gradient of a conjugate gradient method
    kDirect,             ///< exact, for islands of up to `direct_rows` rows
    kImpulse,            ///< one collision after the other, each with its own restitution
    kProjection,         ///< positions are moved apart, velocities follow from them
    kPenalty,            ///< springs and dampers where shapes overlap
};

/// The law by which friction is bounded.
enum class FrictionModel : std::uint8_t {
    kCone,     ///< the size of the friction is at most the coefficient times the load
    kPyramid,  ///< along each of two tangents; up to sqrt(2) times as much between them
    kWeight,   ///< along each tangent at most coefficient x mass x gravity, whatever the load
};

/// The rows that stand for a manifold of several points.
enum class ManifoldMode : std::uint8_t {
    kPoints,   ///< a normal row and friction for each point
    kDivided,  ///< one normal row at the centre of pressure, divided among the points; friction and
               ///< a moment about the normal at the same place
};

/// How overlaps and the gaps of joints are undone.
enum class Stabilisation : std::uint8_t {
    kBaumgarte,  ///< the velocity is asked to undo the share `beta` of the error within a solve
    kSoft,       ///< rows are springs and dampers
    kSplit,      ///< velocities that last for one solve and leave no momentum move the bodies apart
};

enum class PenaltyIntegrator : std::uint8_t {
    kSemiImplicitEuler,
    kVelocityVerlet,
};

/// Parameters of all methods but kSoftStep. PhysicsSettings::substeps counts for them too; 0 stands
/// for 1, for 4 with kProjection and for 16 with kPenalty.
struct VariantSettings {
    int iterations = 20;             ///< passes of a solve, 1..1000
    float tolerance_mps = 0.0F;      ///< stop when the residual is below this; 0: never
    float omega = 1.3F;              ///< kOverRelaxation: (0, 2)
    std::uint32_t shuffle = 0;       ///< not 0: rows are visited in an order drawn from this seed
    bool warm_start = true;          ///< impulses of the last solve are the first guess of the next
    std::int32_t direct_rows = 400;  ///< kDirect: larger islands go to Gauss-Seidel, 1..2000
    FrictionModel friction = FrictionModel::kCone;
    ManifoldMode manifold = ManifoldMode::kPoints;
    Stabilisation stabilisation = Stabilisation::kBaumgarte;
    float beta = 0.2F;                ///< kBaumgarte, kSplit: share of the error per solve, [0, 1];
                                      ///< a single row is stable below 2
    float soft_hz = 15.0F;            ///< kSoft: frequency on the effective mass of a row
    float soft_damping_ratio = 5.0F;  ///< kSoft: 1 is critical
    float slop_m = 0.001F;            ///< kBaumgarte, kSplit: overlap of shapes that is left alone
    float push_speed_mps = 3.0F;      ///< overlaps are undone no faster than this
    /// kPenalty: stiffness as the share of the longest stable time step that a substep takes, (0,
    /// 1); see collision_response.h.
    float penalty_share = 0.5F;
    float penalty_damping_ratio = 0.3F;  ///< kPenalty: 1 is critical, [0, 2]
    PenaltyIntegrator penalty_integrator = PenaltyIntegrator::kSemiImplicitEuler;
    bool measure = false;  ///< fill residual and energies of VariantStats: one more pass a solve
    bool keep_problem = false;  ///< keep the first system of rows of a step as it was before its
                                ///< solve: Scene::problem
};

/// Counts of the solves of a step; all zero with kSoftStep.
struct VariantStats {
    std::uint32_t rows = 0;        ///< of the first solve
    std::uint32_t iterations = 0;  ///< passes of all solves
    std::uint32_t direct = 0;      ///< islands that were solved exactly
    std::uint32_t too_large = 0;   ///< kDirect: islands with too many rows, left to Gauss-Seidel
    std::uint32_t unsolved = 0;    ///< kDirect: islands where pivoting found no end, likewise
    double residual_mps = 0.0;     ///< after the last solve, see residual.h
    double bias_in_j = 0.0;   ///< energy that rows put in which undo errors, J (not kProjection)
    double bias_out_j = 0.0;  ///< energy that they took out, J
};

}  // namespace zoned::physics
