// ContactSolver: substepped sequential impulses with soft contacts, warm starting and friction.
#pragma once

#include "server/physics/bodies.h"
#include "server/physics/contact_graph.h"

#include <array>
#include <cstdint>
#include <vector>

namespace zoned::physics {

/// What the solver moves. Row 0 stands for everything that does not move.
struct SolverBody {
    Vec3 velocity = Vec3::Zero();
    Vec3 spin = Vec3::Zero();
    Vec3 shift = Vec3::Zero();        ///< how far it moved since the step began
    Vec3 turn = Vec3::Zero();         ///< how far it turned, as a rotation vector of first order
    Mat3 inv_inertia = Mat3::Zero();  ///< world
    float inv_mass = 0.0F;
    Vec3 start_velocity = Vec3::Zero();  ///< at the start of the substep, before gravity
    Quat orientation = Quat::Identity();
    std::uint32_t row = kNoIndex;  ///< in Bodies
};

/// The solver follows Box2D 3's "soft step" (E. Catto, "Solver2D", 2024): each substep integrates
/// velocities, applies the last impulses again, solves with contacts as stiff damped springs,
/// integrates positions, and solves again without the springs, so that what pushed shapes apart
/// does not stay in the velocities as energy. Restitution comes last. Beyond it:
/// - An impulse always acts on both bodies at one and the same point in space, although they move
///   between substeps, so that angular momentum is conserved to rounding.
/// - Positions follow the mean velocity of a substep where the change of velocity is due to forces:
///   exact under constant acceleration.
/// - The speed of impact that restitution uses is that at the moment of contact, from the gap that
///   was left; and an impulse that stopped an impact is not used for warm starting.
class ContactSolver {
  public:
    struct Parameters {
        Vec3 gravity = Vec3::Zero();
        float dt = 0.0F;
        int substeps = 4;
        int iterations = 1;
        int relax_iterations = 1;
        float restitution_speed = 0.5F;  ///< slower impacts do not bounce, m/s
    };

    /// Makes room for that many bodies and contacts.
    void reserve(std::size_t bodies, std::size_t contacts);

    /// Takes the simulated bodies of `awake_list`, the kinematic ones of `mover_list` and the
    /// contacts in `list`; writes poses, velocities and impulses back. A
    /// body whose result is not finite or out of range keeps its pose, stops, and is appended to
    /// `broken`.
    void solve(Bodies& bodies,
               ContactGraph& graph,
               const std::vector<std::uint32_t>& list,
               const Parameters& parameters,
               std::vector<std::uint32_t>& broken);

  private:
    struct Point {
        Vec3 moment_a, moment_b;  // arm x normal
        float separation, mass, impulse, total, impact, lever;
    };

    struct Constraint {
        std::uint32_t a, b, contact;
        int count;
        Vec3 normal, tangent1, tangent2, lead;
        float friction, restitution;
        float follow_b;  ///< 1: the point of contact travels with b, 0: with a
        Vec3 moment1_a, moment1_b, moment2_a, moment2_b;  // friction anchor's arm x tangent
        float inv11, inv12, inv22;                        // inverse of the 2 x 2 friction mass
        float twist_mass;
        float impulse1, impulse2, twist;
        bool watched;  // impact speeds are wanted
        bool impact;   // in this substep
        std::array<Point, kMaxManifoldPoints> points;
    };

    /// How far the bodies have drifted apart from where they stand at the contact. Arms that
    /// started at one point end at one point again: a's grows by `shift_a`, b's by `shift_b`.
    struct Drift {
        Vec3 offset;              ///< of b relative to a
        float closing;            ///< its part along the normal
        Vec3 shift_a, shift_b;    ///< their difference is the offset
        Vec3 moment_a, moment_b;  ///< shift x normal
    };

    void gather(Bodies& bodies);
    void prepare(const Bodies& bodies,
                 const ContactGraph& graph,
                 const std::vector<std::uint32_t>& list);
    void prepare_friction(Constraint& c,
                          const SolverBody& a,
                          const SolverBody& b,
                          const Contact& contact) const;
    void integrate_velocities();
    void integrate_positions(const Bodies& bodies);
    void substep(const Bodies& bodies);
    void follow_mean_velocity();
    void watch_impacts(Constraint& c) const;
    void warm_start(Constraint& c);
    template <bool kSoft>
    void solve_constraint(Constraint& c);
    void solve_friction(Constraint& c, SolverBody& a, SolverBody& b, const Drift& drift) const;
    void end_substep(Constraint& c) const;
    void restitute();
    void store(Bodies& bodies, ContactGraph& graph, std::vector<std::uint32_t>& broken) const;
    [[nodiscard]] Drift drift_of(const Constraint& c,
                                 const SolverBody& a,
                                 const SolverBody& b) const;

    /// The contact spring of this step.
    struct Softness {
        float bias_rate, mass_scale, impulse_scale;
    };

    Parameters parameters_;
    Softness softness_{};
    float h_ = 0.0F;
    std::vector<SolverBody> moving_;
    std::vector<Constraint> constraints_;
};

}  // namespace zoned::physics
