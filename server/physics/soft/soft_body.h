// SoftBody: the columns of one soft body, and the stages of its step.
#pragma once

#include "server/physics/simd/node_lanes.h"
#include "server/physics/soft/collision/skin.h"
#include "server/physics/soft/spring_batches.h"
#include "shared/math/aabb.h"

namespace zoned::compute {
class Team;
}

namespace zoned::physics {
class Scene;
}

namespace zoned::physics::soft {

/// A node near a rigid body: it stays on this side of a plane that moves with the body.
struct NodeContact {
    std::uint32_t node;
    BodyId body;
    Vec3 point;   ///< on the surface at the start of the step
    Vec3 normal;  ///< away from the body
    Vec3 moved;   ///< of the surface since then, m
};

/// Numbers that implicit Euler needs while it solves.
struct ImplicitWork {
    std::vector<Vec3d> at, force, residual, direction, image, change, scaled, trial;
    std::vector<Eigen::Matrix3d> inverse_diagonal;
    std::vector<Vec3d> unit;   ///< of each spring
    std::vector<Vec3d> stiff;  ///< along, across, length of each spring
    std::vector<std::array<Vec3d, 4>> volume_gradient;
    std::vector<Vec3d> gas_gradient;
    std::uint32_t newton_steps = 0;  ///< of the step
    std::uint32_t gradient_passes = 0;
};

/// Of semi-implicit Euler; see spring_limit.h.
struct LimitWork {
    double longest_step_s = 0.0;  ///< that push_springs bears
    std::vector<double> share, sizes;
};

struct SoftBody {
    std::vector<Row4> x;          ///< position, inverse mass (0 where pinned)
    std::vector<Row4> v;          ///< velocity, 0
    std::vector<Row4> start;      ///< x before the substep
    std::vector<Row4> kept;       ///< x before the step
    std::vector<Row4> predicted;  ///< x where no force but gravity and drag acted
    std::vector<float> mass;      ///< kg, of pinned nodes too
    std::vector<Spring> springs;
    SpringBatches batches;
    std::vector<SoftFace> faces;
    std::vector<SoftTetrahedron> tetrahedra;
    std::vector<float> rest_volume;  ///< of each tetrahedron, m3
    std::vector<SoftVertex> vertices;
    std::vector<SoftFace> drawn_faces;
    std::vector<std::uint32_t> surface;  ///< nodes of the faces, ascending (where there is gas)
    double gas = 0.0;                    ///< p V, J; 0: none
    SoftSkin skin;
    SoftMaterial material;
    SoftSolver solver;
    std::uint32_t user = 0;

    std::vector<NodeContact> contacts;
    std::vector<BodyId> neighbours;  ///< rigid bodies near it
    std::vector<std::array<std::uint32_t, 2>> close_pairs;
    std::vector<std::uint64_t> grid;    ///< work of self-collision
    std::vector<std::uint64_t> linked;  ///< springs as pairs of nodes, ascending
    std::vector<Vec3d> gradient;        ///< work of the gas
    ImplicitWork implicit;
    std::vector<Row4> impulse;  ///< work of push_springs, N s
    LimitWork limit;

    std::uint32_t substeps_done = 0;  ///< in the step
    /// Nodes that other soft bodies held off in the last substep, of its island; counted at the
    /// first body.
    std::uint32_t held = 0;

    Aabb box;
    float still_s = 0.0F;  ///< for how long it has been slow
    bool there = false;
    bool asleep = false;
    bool rigid = false;  ///< simulated as a rigid body elsewhere
    bool touches_dynamic = false;
    std::uint32_t torn = 0;  ///< springs so far

    [[nodiscard]] Vec3 position(std::size_t i) const { return x[i].head<3>(); }

    /// Of a tetrahedron, m.
    [[nodiscard]] std::array<Vec3d, 4> corners(std::size_t tetrahedron) const {
        const SoftTetrahedron& t = tetrahedra[tetrahedron];
        return {position(t[0]).cast<double>(),
                position(t[1]).cast<double>(),
                position(t[2]).cast<double>(),
                position(t[3]).cast<double>()};
    }

    /// Of a step of dt s.
    [[nodiscard]] int substeps(float dt) const;
    /// So many that loads pass through the body, one node each.
    [[nodiscard]] int relaxed_substeps() const;
};

SoftBody make_body(const SoftDef& def);

// The stages of a step, in order. A substep moves x from `predicted` to where constraints want it.

/// Gravity and drag exactly, constant force: v' = g - c v.
void predict(SoftBody& body, const Vec3& gravity, float h);
void solve_xpbd(SoftBody& body, float h, compute::Team* team);
void solve_implicit(SoftBody& body, float h);
/// Semi-implicit Euler, before predict: springs, tetrahedra and gas change velocities by the nodes'
/// positions, and the velocities then move the nodes.
void push_springs(SoftBody& body, float h);
/// Velocities follow from the moves by constraints.
void finish(SoftBody& body, float h);

/// Volume within the faces, m3; adds its derivatives by the nodes to `gradient` (m2) if not null.
double enclosed_volume(const SoftBody& body, std::vector<Vec3d>* gradient);

/// Kinetic and potential energy, see SoftBodies::energy, J.
double energy_of(const SoftBody& body, const Vec3& gravity);

/// Rigid bodies that are faster are seen only when they are near, m/s.
inline constexpr float kFastBody = 60.0F;

/// Which surfaces nodes may meet within the step.
void find_contacts(SoftBody& body, const Scene& scene, float dt);
/// Pushes nodes off surfaces and gives the bodies the opposite impulse.
void solve_contacts(SoftBody& body, Scene& scene, float h);
/// Which nodes without a spring between them are closer than twice the thickness.
void find_close_pairs(SoftBody& body);
void solve_close_pairs(SoftBody& body);

/// Permanent set. True where rest lengths changed.
bool creep(SoftBody& body, float dt);
/// Breaks springs and splits the mesh. Number of springs that broke.
std::uint32_t tear(SoftBody& body);
/// After springs were added, removed or led to other nodes.
void relink(SoftBody& body);
/// Finds limit.longest_step_s, for the nodes as they lie, where the method needs it.
void limit_step(SoftBody& body);

/// Gas that would be pressed into less pushes as it does there, m3.
inline double least_gas_volume(const SoftBody& body) {
    return 1.0e-3 * body.gas / static_cast<double>(body.material.gas_pressure);
}

}  // namespace zoned::physics::soft
