// The relax pass of the joint solver: velocities without errors of position, and without energy of
// its own making.
#include "server/physics/joints/joint_solver.h"

namespace zoned::physics {

namespace {

/// A body that turned farther than this since rows were written, rad, is no longer where they say.
constexpr float kFarTurn = 0.25F;
/// A relax pass may make this share of its bodies' energy: motors work meanwhile.
constexpr double kMostRelaxed = 0.01;

}  // namespace

/// An impulse acts on both bodies at one point, and the point is b's. Arms that were left where the
/// bodies stood before would make momentum. What the rows say about speeds stays: it is true for
/// the middle of the substep. So does the matrix, which has to stay symmetric.
void JointSolver::follow(const SolverBodies& moving) {
    for (JointGroup& group : groups_) {
        group.turned = false;
    }
    for (const JointItem& item : items_) {
        for (const std::uint32_t slot : {item.a, item.b}) {
            const Vec3 turn = SolverBodies::angular({moving.drift[slot].at - seen_[slot].at});
            groups_[item.group].turned |= turn.squaredNorm() > kFarTurn * kFarTurn;
        }
        const Vec3 apart = SolverBodies::linear({moving.drift[item.b].at - seen_[item.b].at}) -
                           SolverBodies::linear({moving.drift[item.a].at - seen_[item.a].at});
        for (std::size_t r = item.first; r < item.first + item.count; ++r) {
            Row& row = rows_[r];
            const Vec3 linear = SolverBodies::linear(row.along_b);
            const Vec3 angular_a = SolverBodies::angular(row.along_a) - apart.cross(linear);
            row.push_a = give(moving, item.a, -linear, angular_a);
            row.push_b = give(moving, item.b, linear, SolverBodies::angular(row.along_b));
        }
    }
    for (const JointGroup& group : groups_) {
        if (!group.direct) {
            fill_turns(group);
        }
    }
}

/// Impulses of the relax pass are computed for the bodies as the rows saw them, and act where the
/// bodies are by now: see `follow`. Where a body has turned far in between, they may push with its
/// motion in place of against it.
void JointSolver::solve_relaxed(SolverBodies& moving) {
    for (const JointGroup& group : groups_) {
        if (!group.turned) {
            solve(moving, group);
            continue;
        }
        note_motion(moving, group);
        const double before = energy_of(moving, group);
        solve(moving, group);
        if (!(energy_of(moving, group) <= (1.0 + kMostRelaxed) * before)) {
            take_back(moving, group);
        }
    }
}

/// Twice the energy of motion of a group's bodies, J.
double JointSolver::energy_of(const SolverBodies& moving, const JointGroup& group) const {
    double sum = 0.0;
    for (std::uint32_t i = group.first; i < group.end; ++i) {
        for (const std::uint32_t slot : {items_[i].a, items_[i].b}) {
            const std::uint32_t joints = first_of_[slot + 1] - first_of_[slot];
            if (slot != 0 && joints != 0) {  // each joint of a body brings its share of the body
                const Row8& motion = moving.motion[slot];
                sum += static_cast<double>(sum_of(moving.momentum(slot, motion).at * motion.at)) /
                       static_cast<double>(joints);
            }
        }
    }
    return sum;
}

void JointSolver::note_motion(const SolverBodies& moving, const JointGroup& group) {
    noted_.resize(2 * items_.size());
    for (std::uint32_t i = group.first; i < group.end; ++i) {
        noted_[2 * i] = moving.motion[items_[i].a];
        noted_[2 * i + 1] = moving.motion[items_[i].b];
    }
    for (std::uint32_t r = group.first_row; r < group.end_row; ++r) {
        rows_[r].noted = rows_[r].impulse;
    }
}

void JointSolver::take_back(SolverBodies& moving, const JointGroup& group) {
    for (std::uint32_t i = group.first; i < group.end; ++i) {
        moving.motion[items_[i].a] = noted_[2 * i];
        moving.motion[items_[i].b] = noted_[2 * i + 1];
    }
    for (std::uint32_t r = group.first_row; r < group.end_row; ++r) {
        rows_[r].impulse = rows_[r].noted;
    }
}

}  // namespace zoned::physics
