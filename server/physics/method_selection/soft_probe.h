// Soft probe: a soft body on its own for a second, by any method, and the solution to compare with.
#pragma once

#include "server/physics/soft/soft_bodies.h"

#include <string>
#include <vector>

namespace zoned::physics::method_selection {

/// The result of a run.
struct ProbeRun {
    std::vector<Vec3> places;   ///< of all nodes, moment by moment
    double newton_steps = 0.0;  ///< in all
    double gradient_passes = 0.0;
    bool broke = false;  ///< its state did not stay finite
};

/// The run that others are measured by.
struct ProbeReference {
    ProbeRun run;
    /// Mean distance from the same solution with steps twice as long, as a share of the size: added
    /// to every error, since the reference may be off by as much.
    double change = 0.0;
    std::string how;  ///< "semi-implicit Euler in 128 substeps a tick"
};

/// A body with a pinned node falls as it is pinned. One without is stretched by a fifth along its
/// longest side, drawn in across so that its volume stays, and let go without weight (a fall does
/// not deform it). Nothing tears, sets, or touches anything.
class SoftProbe {
  public:
    /// `def` is fit; gravity in m/s2, `tick_s` > 0.
    SoftProbe(const soft::SoftDef& def, const Vec3& gravity, float tick_s);

    /// A second; each tick in `splits` >= 1 steps of solver.substeps each.
    [[nodiscard]] ProbeRun run(const soft::SoftSolver& solver, int splits = 1) const;

    /// The mean distance of nodes, as a share of the size of the body (the longest side of its
    /// box): the largest over the tenths of the second. Infinity where one of them broke.
    [[nodiscard]] double distance(const ProbeRun& a, const ProbeRun& b) const;

    /// Semi-implicit Euler with steps of 1/3840 s or shorter. Steps are halved until a halving
    /// changes less than a tenth of `budget` or would take more than kMostReference of springs and
    /// tetrahedra. Where even that is too much (springs too stiff), XPBD is refined in the same
    /// way, in at most 512 substeps a tick.
    [[nodiscard]] ProbeReference reference(double budget) const;

    [[nodiscard]] int ticks() const { return ticks_; }

    /// Whether it hangs from a pinned node; otherwise it was stretched and let go.
    [[nodiscard]] bool pinned() const { return pinned_; }

  private:
    [[nodiscard]] ProbeRun run_in(soft::SoftMethod method, int substeps) const;

    soft::SoftDef def_;
    Vec3 gravity_;
    float tick_s_;
    int ticks_ = 1;
    double size_ = 1.0;
    bool pinned_ = false;
};

/// Limit of springs (and equally slow parts) times substeps for a reference: some 0.1 s.
inline constexpr double kMostReference = 4.0e7;

}  // namespace zoned::physics::method_selection
