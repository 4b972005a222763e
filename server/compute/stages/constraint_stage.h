// ConstraintStage: passes over the distance constraints of soft bodies, colour by colour.
// Reached by no program yet: soft bodies on a device will use it.
#pragma once

#include "server/compute/stages/particle_stage.h"
#include "kernels/include/constraint.h"
#include "shared/core/result.h"

#include <memory>
#include <span>
#include <vector>

namespace zoned::compute {

/// Links ordered by colour: links of one colour share no node. They may be solved in any order,
/// eight at a time, on threads or on a device, with the same result.
class ColouredLinks {
  public:
    /// Greedy: each link in its turn takes the first colour that neither of its nodes has. That is
    /// at most one colour more than twice the most links of a node, less two. Fails with the link's
    /// number where a node is not in [0, nodes), a link joins a node to itself, or a rest length is
    /// not above 0. It also fails where a compliance is below 0 or not finite, or more than 64
    /// colours are needed.
    static core::Result<ColouredLinks> make(std::span<const kernels::DistanceLink> links,
                                            std::size_t nodes);

    [[nodiscard]] const std::vector<kernels::DistanceLink>& links() const { return links_; }

    /// First link of each colour, and the end.
    [[nodiscard]] const std::vector<std::size_t>& colour_begin() const { return begin_; }

    [[nodiscard]] std::size_t colours() const { return begin_.size() - 1; }

  private:
    std::vector<kernels::DistanceLink> links_;
    std::vector<std::size_t> begin_{0};
};

/// The layout of the columns of nodes: positions as particles have, then the inverse mass (1/kg).
inline constexpr std::size_t kInverseMass = ParticleColumns::kVx;

/// `passes` passes over all colours in order, with lambdas from zero, for a step of h seconds.
class ConstraintStage {
  public:
    explicit ConstraintStage(Device* device = nullptr);
    ~ConstraintStage();
    ConstraintStage(ConstraintStage&&) noexcept;
    ConstraintStage& operator=(ConstraintStage&&) noexcept;

    /// Where a device fails, the positions are restored, and the CPU does all passes: the stage
    /// keeps a copy of the nodes for that.
    StageRun solve(ParticleColumns& nodes,
                   std::size_t count,
                   const ColouredLinks& links,
                   float h,
                   int passes,
                   Team& team);

    [[nodiscard]] bool has_device() const;

  private:
    struct OnDevice;

    void solve_on_cpu(ParticleColumns& nodes,
                      const ColouredLinks& links,
                      float h,
                      int passes,
                      Team& team);

    std::vector<float> lambdas_;
    std::unique_ptr<OnDevice> on_device_;
};

}  // namespace zoned::compute
