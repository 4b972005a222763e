// JointSolver: holds joints together, all of an island at once.
#pragma once

#include "server/physics/bodies/solver_bodies.h"
#include "server/physics/joints/envelope_solver.h"
#include "server/physics/joints/joint_table.h"
#include "server/physics/simd/lanes.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::physics {

/// The rows J V = -C / h of all joints that hang together are one linear system
/// J M^-1 J^T x = b, solved directly in each substep: a chain that carries a hundred times its
/// weight stays together as one that carries nothing, which no number of single passes achieves
/// (D. Baraff, "Linear-time dynamics using Lagrange multipliers", SIGGRAPH 1996). Joints are
/// ordered by a walk over the bodies that they share, so that the matrix is narrow; where it would
/// be too wide all the same (nets of hundreds), rows are solved one after the other, in layers of
/// the walk: joints of a layer that share no body are solved side by side, eight at a time (E.
/// Anderson, Y. Saad, "Solving sparse triangular linear systems on parallel computers", Int. J.
/// High Speed Computing 1, 1989). Where no row has bounds, such passes are steps of conjugate
/// gradients.
///
/// Limits and motors are rows of the same system for as long as their impulses are within bounds:
/// the set of those that hold is carried from substep to substep and corrected by a few rounds
/// (block pivoting: Judice, Pires, "A block principal pivoting algorithm for large-scale strictly
/// monotone linear complementarity problems", Computers & Operations Research 21, 1994). Solved by
/// itself, a motor would see the moment of a link about its middle and not about its hinge.
///
/// Substeps are those of SHAKE in its leapfrog form (Ryckaert, Ciccotti, Berendsen, J. Comp. Phys.
/// 23, 1977): rows at the middle of the substep push velocities so that the constraint holds at the
/// middle of the next, and positions follow in straight lines. It is of second order and keeps the
/// energy of a pendulum; velocities that were made tangent after each substep would lose (w h)^2
/// of it each time. The caller moves positions by half a substep first and last.
class JointSolver {
  public:
    void reserve(std::size_t joints);
    void reserve_bodies(std::size_t bodies);  ///< that joints may hold

    /// Takes the joints and their bodies in. `h`: length of a substep; `lead`: how long bodies move
    /// before the first update, s.
    void prepare(Bodies& bodies,
                 const JointTable& table,
                 std::span<const std::uint32_t> joints,
                 SolverBodies& moving,
                 float h,
                 float lead);

    [[nodiscard]] bool empty() const { return items_.empty(); }

    /// Whether `solve` leaves no row open.
    [[nodiscard]] bool exact() const { return exact_; }

    /// Rows at the present poses, with velocities that no force of this substep has changed yet.
    void update(const JointTable& table, const SolverBodies& moving);
    /// Gives the last impulses again and prepares the systems.
    void warm_start(SolverBodies& moving);
    void solve(SolverBodies& moving);
    /// Solves those alone of which a joint would open visibly in this substep; true: there are any.
    bool close(SolverBodies& moving);
    /// The same for those alone that hang together with these slots; not where rows are solved one
    /// after the other: such a graph is as good as loose for the moment of a blow.
    void solve_around(SolverBodies& moving, std::uint32_t slot_a, std::uint32_t slot_b);

    /// Calls visit(slot) for all slots that `solve_around` may move with this one, some of them
    /// several times.
    template <class Visit>
    void for_each_tied(std::uint32_t slot, Visit&& visit) const {
        const std::uint32_t group = group_of(slot);
        for (std::uint32_t i = group != kNoIndex ? groups_[group].first : 0;
             group != kNoIndex && i < groups_[group].end;
             ++i) {
            visit(items_[i].a);
            visit(items_[i].b);
        }
    }

    /// Remembers the impulses of the joints that `solve_around` would solve. Until `end_blow` no
    /// spring is among them: its force is finite, and a blow takes no time.
    void begin_blow(std::uint32_t slot_a, std::uint32_t slot_b);
    void end_blow(std::uint32_t slot_a, std::uint32_t slot_b);

    /// Leaves a share of what they gave since then.
    void restore_impulses(std::uint32_t slot_a, std::uint32_t slot_b, float left);

    /// Work since then, J, through these joints by bodies that impulses do not move.
    [[nodiscard]] float work_of_movers(const SolverBodies& moving,
                                       std::uint32_t slot_a,
                                       std::uint32_t slot_b) const;

    /// Calls visit(a, b, impulse on b) for these joints: what they gave since then, N s.
    template <class Visit>
    void for_each_pull(std::uint32_t slot_a, std::uint32_t slot_b, Visit&& visit) const {
        for_each_around(slot_a, slot_b, [&](const JointGroup& group) {
            for (std::uint32_t i = group.first; i < group.end; ++i) {
                Vec3 pull = Vec3::Zero();
                for (std::size_t r = items_[i].first; r < items_[i].first + items_[i].count; ++r) {
                    const Row& row = rows_[r];
                    pull += (row.impulse - row.noted) * SolverBodies::linear(row.along_b);
                }
                visit(items_[i].a, items_[i].b, pull);
            }
        });
    }

    /// From now on velocities no longer undo what is left of former errors. True if any did.
    bool relax();
    /// Impulses act from now on where the bodies went since the last update.
    void follow(const SolverBodies& moving);
    /// `solve` after `relax`. Joints that make energy by it change nothing.
    void solve_relaxed(SolverBodies& moving);
    /// Ends a substep: notes the impulses that the joints carried.
    void add_totals();

    void store(JointTable& table, const SolverBodies& moving) const;

  private:
    struct JointItem {
        std::uint32_t joint = 0;
        std::uint32_t a = 0, b = 0;  // slots
        JointPose pose_a, pose_b;    // when the step began; the common origin is near b
        Quat orientation_a = Quat::Identity();
        Quat orientation_b = Quat::Identity();
        std::uint32_t first = 0;  // of its rows, here and in the matrix
        std::uint32_t count = 0;
        std::uint32_t group = 0;
        std::uint32_t earliest = 0;   // first row that it shares a body with
        std::uint32_t layer = 0;      // joints between it and the first one of the group
        Vec3 carried = Vec3::Zero();  // sum of the impulses of all substeps, N s
    };

    /// A row and its equation: J V + soft x impulse = -bias, low <= impulse <= high.
    struct Row {
        Row8 along_a, along_b;  // J: the row's share in either motion
        Row8 give_a, give_b;    // M^-1 J^T: what an impulse of 1 changes in either motion
        Row8 push_a, push_b;    // the same where the bodies are by now: see `follow`
        float response = 0.0F;  // J M^-1 J^T
        float soft = 0.0F;
        float bias = 0.0F;
        float undo = 0.0F;  // on top of the bias: undoes what is left of former errors
        float low = 0.0F, high = 0.0F;
        float impulse = 0.0F;
        float noted = 0.0F;  // impulse before a blow
        /// The error that the row would have at the last update, had it been straight since then.
        float straight_error = 0.0F;
        float sudden = 0.0F;  ///< of the error: what came from outside since the last step
        float error = 0.0F;   ///< C at the last update, m or rad
        RowKind kind = RowKind::kHard;
        bool held = true;  // in the system of equations; otherwise its impulse stays
    };

    /// Joints that hang together through bodies that move.
    struct JointGroup {
        std::uint32_t first = 0, end = 0;              // of items
        std::uint32_t first_row = 0, end_row = 0;      // of rows
        std::uint32_t first_batch = 0, end_batch = 0;  // where it is not solved directly
        std::uint32_t first_slot = 0, end_slot = 0;    // its bodies there, in tied_
        bool direct = true;
        bool bounded = false;  // has rows with bounds
        bool springy = false;  // has springs
        bool turned = false;   // a body turned far since the last update
    };

    /// Up to eight joints that share no body that moves, solved side by side.
    struct JointBatch {
        LaneRows item{};  // kNoIndex: none
        LaneRows a{}, b{};
        std::uint32_t first = 0;  // of its rows in batch_rows_
        std::uint32_t count = 0;
    };

    /// One row of each of eight joints. Lanes without one have a `mass` of zero.
    struct RowLanes {
        Lanes3 linear, angular_a, angular_b;  // J, as of Row
        Lanes3 turn_a, turn_b;                // the change of spin by an impulse of 1
        Lanes mass{};                         // 1 / (J M^-1 J^T + soft)
        Lanes soft{}, bias{}, undo{};
        Lanes low{}, high{};
        Lanes impulse{};
        // Of conjugate gradients.
        Lanes open{};  // what the row lacks
        Lanes more{};  // impulses that a pass from end to end would add
        Lanes way{};   // change of the impulses in a step of one
        Lanes bend{};  // what that changes in `open`, negated
    };

    /// The change of a body's motion by an impulse and a moment.
    static Row8 give(const SolverBodies& moving,
                     std::uint32_t slot,
                     const Vec3& push,
                     const Vec3& moment);
    [[nodiscard]] std::uint32_t group_of(std::uint32_t slot) const;

    template <class Visit>
    void for_each_around(std::uint32_t slot_a, std::uint32_t slot_b, Visit&& visit) const {
        const std::uint32_t a = group_of(slot_a);
        const std::uint32_t b = group_of(slot_b);
        for (const std::uint32_t group : {a, b == a ? kNoIndex : b}) {
            if (group != kNoIndex) {
                visit(groups_[group]);
            }
        }
    }

    // joint_order.cpp
    void order(const SolverBodies& moving);
    void walk(std::uint32_t from);
    void shape_matrix();
    void batch_joints(JointGroup& group);
    void batch_layer(std::uint32_t begin, std::uint32_t end);

    // joint_sweeps.cpp
    void fill_batches(const JointGroup& group);
    void fill_turns(const JointGroup& group);
    void load_impulses(const JointGroup& group);
    void store_impulses(const JointGroup& group);
    void solve_singly(SolverBodies& moving, const JointGroup& group);
    void solve_batch(SolverBodies& moving, const JointBatch& batch);
    void solve_by_gradients(SolverBodies& moving, const JointGroup& group);
    void begin_gradients(const SolverBodies& moving, const JointGroup& group);
    float pass_forward(const JointGroup& group, float step);
    double pass_back(const JointGroup& group);
    double lead_way(const JointGroup& group, float keep);
    void list_tied(JointGroup& group);

    [[nodiscard]] float gape(const SolverBodies& moving, std::uint32_t slot, float arm) const;
    [[nodiscard]] float swing(const SolverBodies& moving,
                              const JointItem& item,
                              float length) const;
    [[nodiscard]] float moved(const SolverBodies& moving,
                              const JointItem& item,
                              const Row& row) const;
    static void place_row(const SolverBodies& moving,
                          const JointItem& item,
                          const JointRow& from,
                          Row& row);
    void update_row(const SolverBodies& moving,
                    const JointItem& item,
                    const JointRow& from,
                    float bend,
                    Row& row) const;
    void restrain_motor(const JointItem& item);
    void aim_hard(float bend, Row& row) const;
    void update_spring(const SolverBodies& moving,
                       const JointItem& item,
                       const JointDef& spring,
                       Row& row) const;
    void hold_springs(const JointGroup& group, bool held);
    void choose_held(const SolverBodies& moving, const JointGroup& group);
    void factor(const JointGroup& group);
    void assemble(const JointItem& item);
    void add_column_blocks(const JointItem& q, std::size_t first, std::uint32_t slot);
    void solve(SolverBodies& moving, const JointGroup& group);
    [[nodiscard]] double energy_of(const SolverBodies& moving, const JointGroup& group) const;
    void note_motion(const SolverBodies& moving, const JointGroup& group);
    void take_back(SolverBodies& moving, const JointGroup& group);
    [[nodiscard]] bool opens(const SolverBodies& moving, const JointGroup& group) const;
    void solve_group(SolverBodies& moving, const JointGroup& group);
    void find_unknowns(const SolverBodies& moving, const JointGroup& group);
    [[nodiscard]] static double share_to_bound(const Row& row, double unknown);
    bool release(SolverBodies& moving, const JointGroup& group);
    bool take_hold(const SolverBodies& moving, const JointGroup& group);
    void apply_unknowns(SolverBodies& moving, const JointGroup& group);

    [[nodiscard]] float bias_of(const Row& row) const { return row.bias + undoing_ * row.undo; }

    [[nodiscard]] static float along(const Row& row, const Lanes& a, const Lanes& b);
    [[nodiscard]] static float speed(const SolverBodies& moving,
                                     const JointItem& item,
                                     const Row& row);
    /// Takes the impulse to `impulse`, within its bounds.
    static void move_impulse(SolverBodies& moving, const JointItem& item, Row& row, float impulse);
    static void apply(SolverBodies& moving, const JointItem& item, const Row& row, float impulse);

    float h_ = 0.0F;
    int substeps_ = 0;  // since `prepare`
    bool exact_ = true;
    float undoing_ = 0.0F;  // 1: velocities undo former errors
    std::vector<JointItem> items_;
    std::vector<Row> rows_;
    std::vector<Row8> seen_;   // how far each slot had gone at the last update
    std::vector<Row8> noted_;  // motions of a and b of each item before a relax pass
    std::vector<JointGroup> groups_;
    EnvelopeSolver matrix_;
    std::vector<double> unknowns_;
    std::vector<std::uint32_t> starts_;
    std::vector<JointBatch> batches_;
    std::vector<RowLanes> batch_rows_;
    std::vector<std::uint32_t> tied_;  // bodies of graphs that are not solved directly
    std::vector<Row8> change_, way_;   // by slot: of the motion, by RowLanes::more and ::way
    std::vector<std::uint64_t>
        colors_;  // by slot: of the layer's joints so far; zero between calls
    std::vector<std::uint8_t> color_of_;  // of the layer's joints
    // Joints by body: of slot s, from first_of_[s] to first_of_[s + 1].
    std::vector<std::uint32_t> first_of_, joints_of_;
    std::vector<JointItem> unordered_;
    std::vector<std::uint8_t> visited_;
    std::vector<std::uint32_t> queue_;
};

}  // namespace zoned::physics
