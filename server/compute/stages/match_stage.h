// MatchStage: aura-nimbus matching: who hears of what, by distance tests through a grid.
#pragma once

#include "server/compute/stages/flock_stage.h"
#include "kernels/include/match.h"

#include <memory>
#include <span>
#include <vector>

namespace zoned::compute {

/// Where the columns of entities have what: x and z as particles have, then the aura (m).
inline constexpr std::size_t kAura = ParticleColumns::kVx;

/// For each viewer the numbers of the entities that it hears of, in the order of cells, then of
/// numbers: the same on lanes, threads and devices.
struct Matches {
    std::vector<std::int32_t> found;  ///< by viewer
    std::vector<std::int32_t> out;    ///< viewer v's begin at v * most
    std::size_t most = 0;             ///< room for each viewer; made larger where it was too little

    [[nodiscard]] std::span<const std::int32_t> of(std::size_t viewer) const {
        return {out.data() + viewer * most, static_cast<std::size_t>(found[viewer])};
    }
};

class MatchStage {
  public:
    explicit MatchStage(Device* device = nullptr);
    ~MatchStage();
    MatchStage(MatchStage&&) noexcept;
    MatchStage& operator=(MatchStage&&) noexcept;

    /// Entities [0, count) over the box (low, high; x and z, m) in cells of `cell_size` (m, > 0).
    /// What lies outside the box is found as well, only slower. A device that fails is given up,
    /// and the CPU does the work.
    StageRun match(const ParticleColumns& entities,
                   std::size_t count,
                   const kernels::FlockRules& box,
                   float cell_size,
                   std::span<const kernels::MatchViewer> viewers,
                   Matches& matches,
                   Team& team);

    [[nodiscard]] bool has_device() const;

  private:
    struct OnDevice;

    FlockOrder order_;
    std::unique_ptr<OnDevice> on_device_;
};

}  // namespace zoned::compute
