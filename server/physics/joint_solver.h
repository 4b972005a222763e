// JointSolver: holds joints together, all of an island at once.
#pragma once

#include "server/physics/envelope.h"
#include "server/physics/joint_table.h"
#include "server/physics/solver_bodies.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::physics {

/// The hard rows J V = -C / h of all joints are one linear system J M^-1 J^T x = b, solved directly
/// in each substep: a chain that carries a hundred times its weight stays together as one that
/// carries nothing, which no number of single passes achieves (D. Baraff, "Linear-time dynamics
/// using Lagrange multipliers", SIGGRAPH 1996). Joints are ordered by a walk over the bodies that
/// they share, so that the matrix is narrow; where it would be too wide all the same (nets of
/// thousands), rows are solved one after the other. Limits, motors and springs are always.
class JointSolver {
  public:
    void reserve(std::size_t joints);

    /// Takes the joints and their bodies in.
    void prepare(Bodies& bodies,
                 const JointTable& table,
                 std::span<const std::uint32_t> joints,
                 SolverBodies& moving,
                 float h);

    [[nodiscard]] bool empty() const { return items_.empty(); }

    /// Rows and matrix at the present poses.
    void update(const JointTable& table, const SolverBodies& moving);
    void warm_start(SolverBodies& moving);
    /// With `biased`, velocities also undo the error within the substep.
    void solve(SolverBodies& moving, bool biased);

    void store(JointTable& table) const;

  private:
    struct Item {
        std::uint32_t joint = 0;
        std::uint32_t a = 0, b = 0;  // slots
        JointPose pose_a, pose_b;    // when the step began; the common origin is near b
        Quat orientation_a = Quat::Identity();
        Quat orientation_b = Quat::Identity();
        std::uint32_t hard = 0;  // first of its rows in the matrix
        std::uint32_t hard_count = 0;
        std::uint32_t first = 0;  // of all its rows in `rows_`
        std::uint32_t count = 0;
        std::uint32_t earliest = 0;  // first row in the matrix that it shares a body with
    };

    /// A row with what its impulses do.
    struct Row {
        JointRow row;
        Vec3 turn_a, turn_b;  // inverse inertia times angular part
        float mass = 0.0F;
        float impulse = 0.0F;
    };

    void order(const SolverBodies& moving);
    void walk(std::uint32_t from);
    void shape_matrix();
    void assemble(const SolverBodies& moving);
    void add_block(const SolverBodies& moving, const Item& p, const Item& q, std::uint32_t slot);
    void solve_hard(SolverBodies& moving, bool biased);
    void solve_single(SolverBodies& moving, const Item& item, Row& row, bool biased) const;
    [[nodiscard]] static float speed(const SolverBodies& moving, const Item& item, const Row& row);
    static void apply(SolverBodies& moving, const Item& item, const Row& row, float impulse);

    float h_ = 0.0F;
    bool direct_ = true;
    std::vector<Item> items_;
    std::vector<Row> rows_;
    EnvelopeSolver matrix_;
    std::vector<double> unknowns_;
    std::vector<std::uint32_t> starts_;
    // Joints by body: of slot s, from first_of_[s] to first_of_[s + 1].
    std::vector<std::uint32_t> first_of_, joints_of_;
    std::vector<Item> unordered_;
    std::vector<std::uint8_t> visited_;
    std::vector<std::uint32_t> queue_;
};

}  // namespace zoned::physics
