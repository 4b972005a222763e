// CrowdFlowField: the next step from every cell to a goal, by paths that avoid crowds.
#pragma once

#include "server/ai/pathfinding/flow_fields/density.h"
#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "server/ai/pathfinding/grid/grid_map.h"
#include "server/ai/pathfinding/grid/search_heap.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// Differs from FlowField in that a step costs more where cells are crowded. The cost is its length
/// times the mean of 1 + crowding / 16 of both cells. When some cells change, only the paths that
/// led through them are looked for again. Costs and steps then equal those of a newly built field:
/// of equally good steps the first is taken, so that the work of later updates does not depend on
/// earlier ones. After Ramalingam and Reps, "An incremental algorithm for a generalization of the
/// shortest-path problem", Journal of Algorithms 21, 1996.
class CrowdFlowField {
  public:
    /// The length of a path; a straight step between empty cells is kStraight * 2 kPerStep.
    using Cost = std::uint64_t;

    static constexpr Cost kNoPath = ~Cost{0};

    /// Builds the field to `goal` (on the map) from everywhere.
    void build(const GridMap& map, std::span<const Crowding> crowding, Cell goal);

    /// Updates after cells in `changed` became passable or blocked, or more or less crowded.
    void update(const GridMap& map,
                std::span<const Crowding> crowding,
                std::span<const Place> changed);

    [[nodiscard]] Hop hop(Place p) const { return hop_[p]; }

    [[nodiscard]] Cost cost(Place p) const { return cost_[p]; }

    /// The same a part at a time. Until advance() returns true nothing else may be called, and
    /// neither map nor crowding may change.
    void begin_build(const GridMap& map, Cell goal);
    void begin_update(std::span<const Place> changed);

    /// Looks at about `most` (> 0) cells; true: the field is up to date.
    bool advance(const GridMap& map, std::span<const Crowding> crowding, std::size_t most);

    /// All costs, by place.
    [[nodiscard]] std::span<const Cost> costs() const { return cost_; }

    /// Cells that the last build() or update() took from its queue.
    [[nodiscard]] std::size_t work() const { return work_; }

    [[nodiscard]] std::size_t bytes() const;

  private:
    struct ReachedCell {
        Cost key;
        Place node;
    };

    /// RepairPhase: the steps of a repair, in order.
    enum class RepairPhase : std::uint8_t {
        kForget,     ///< forget paths through changed cells
        kFindAgain,  ///< find paths again from the remaining cells beside them
        kSpread,
    };

    /// Settles at most `most` cells; true: there are no more.
    bool spread(const GridMap& map, std::span<const Crowding> crowding, std::size_t most);
    void forget(Place p);
    void forget_around(const GridMap& map, Place changed);
    void forget_before(Place p);
    void find_again(const GridMap& map, std::span<const Crowding> crowding, Place p);

    std::vector<Cost> cost_;
    std::vector<Hop> hop_;
    SearchHeap<ReachedCell> open_;
    std::vector<Place> changed_;
    std::vector<Place> forgotten_;
    RepairPhase phase_ = RepairPhase::kSpread;
    std::size_t next_ = 0;     // next entry of forgotten_, in this phase
    std::size_t changes_ = 0;  // entries of changed_ that are done
    Place goal_ = kNoPlace;
    std::uint32_t stride_ = 0;
    std::size_t work_ = 0;
};

}  // namespace zoned::ai::pathfinding
