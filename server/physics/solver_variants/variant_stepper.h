// VariantStepper: a step of contacts and joints by one of the alternatives to ContactSolver.
#pragma once

#include "server/physics/settings/physics_settings.h"
#include "server/physics/solver_variants/projection.h"
#include "server/physics/solver_variants/row_solvers/row_solvers.h"
#include "server/physics/solver_variants/rows/contact_rows.h"
#include "server/physics/solver_variants/rows/joint_row_writer.h"
#include "server/physics/solver_variants/rows/variant_bodies.h"
#include "shared/core/containers/union_find.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::compute {
class Team;
}

namespace zoned::physics {

/// The input of a step; all of it outlives the step.
struct VariantStep {
    Bodies& bodies;
    ContactGraph& graph;
    std::span<const std::uint32_t> contacts;
    JointTable& joints;
    std::span<const std::uint32_t> active_joints;
    const PhysicsSettings& settings;
    float dt = 0.0F;                ///< s
    compute::Team* team = nullptr;  ///< threads that help; null: nobody does
};

/// A step is cut into substeps. Each substep takes forces and writes contacts and joints as rows at
/// the bodies' present poses. The method then solves the rows, and the bodies move with the
/// resulting velocities.
class VariantStepper {
  public:
    void reserve(std::size_t bodies, std::size_t contacts);

    /// Moves the awake bodies that the contacts and joints hold; writes poses, velocities and
    /// impulses back. A body whose result is not finite or out of range keeps its pose, stops, and
    /// is appended to `broken`. `solver_slot` of all awake bodies must be 0 and is so again
    /// afterwards.
    void solve(const VariantStep& step, std::vector<std::uint32_t>& broken);

    /// The same by kDirect in one substep, for contacts and joints that are one island. False, and
    /// nothing is changed, where it finds no answer.
    bool solve_exactly(const VariantStep& step, std::vector<std::uint32_t>& broken);

    [[nodiscard]] const VariantStats& stats() const { return stats_; }

    /// Forgets the results of the last step.
    void reset_stats() { stats_ = VariantStats(); }

    [[nodiscard]] int substeps() const { return substeps_; }

    /// See Scene::problem.
    [[nodiscard]] const RowSystem& problem() const { return problem_; }

    static int substeps_of(const PhysicsSettings& settings);

  private:
    void take_bodies(const VariantStep& step);
    void sort_by_island(const VariantStep& step);
    void write_rows(const VariantStep& step, double h);
    void substep(const VariantStep& step, double h, int index);
    void note_speeds();
    void solve_velocities(const VariantStep& step, double h);
    void split_positions(const VariantStep& step, double h);
    void penalty_substep(const VariantStep& step, double h, int index);
    void store(const VariantStep& step, double h, int index);

    VariantStats stats_;
    int substeps_ = 0;
    RowSystem system_;
    RowSystem problem_;
    VariantBodies moving_;
    ContactRows contacts_;
    JointRowWriter joints_;
    Projection projection_;
    core::UnionFind sets_;
    std::vector<std::uint32_t> contact_list_, joint_list_;
    std::vector<std::uint64_t> keys_;  // island and place of a contact or joint
    std::vector<RowBody> kept_;        // velocities while positions are corrected
    std::vector<double> before_;       // speeds of rows without their impulses
};

}  // namespace zoned::physics
