// CrowdFlowField: from every cell the next step to a goal, by paths that avoid crowds.
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

/// As FlowField, but a step costs more where cells are crowded: its length times the
/// mean of 1 + crowding / 16 of both cells. When some cells change, only what led through them is
/// looked for again (after Ramalingam and Reps, "An incremental algorithm for a generalization of
/// the shortest-path problem", Journal of Algorithms 21, 1996): costs are the same as those of a
/// field that is built anew.
class CrowdFlowField {
  public:
    /// Length of a path, in kStraight * 2 kPerStep for a straight step between empty cells.
    using Cost = std::uint64_t;

    static constexpr Cost kNoPath = ~Cost{0};

    /// Field to `goal` (on the map) from everywhere.
    void build(const GridMap& map, std::span<const Crowding> crowding, Cell goal);

    /// After cells in `changed` became passable or not, or more or less crowded.
    void update(const GridMap& map,
                std::span<const Crowding> crowding,
                std::span<const Place> changed);

    [[nodiscard]] Hop hop(Place p) const { return hop_[p]; }

    [[nodiscard]] Cost cost(Place p) const { return cost_[p]; }

    /// The same a part at a time: nothing else may be asked for, and neither map nor crowding
    /// change, until advance() says so.
    void begin_build(const GridMap& map, Cell goal);
    void begin_update(std::span<const Place> changed);

    /// Looks at `most` (> 0) cells more or less; true: the field is that of now.
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

    /// What is left to do, in order.
    enum class RepairPhase : std::uint8_t {
        kForget,     ///< what led through what has changed
        kFindAgain,  ///< from what is left beside it
        kSpread,
    };

    /// Settles `most` cells at most; true: there are no more.
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
    std::size_t next_ = 0;     // of forgotten_, in this phase
    std::size_t changes_ = 0;  // of changed_, done
    Place goal_ = kNoPlace;
    std::uint32_t stride_ = 0;
    std::size_t work_ = 0;
};

}  // namespace zoned::ai::pathfinding
