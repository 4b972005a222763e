// Landmarks: distances of cells from a few landmark cells, as lower bounds for searches.
#pragma once

#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "server/ai/pathfinding/grid/components.h"
#include "server/ai/pathfinding/grid_search/resumable_task.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::ai::pathfinding {

/// Differential heuristics: for any landmark l no path from a to b is shorter than |d(a, l) - d(b,
/// l)|. Each landmark is the cell farthest from those before it. Sources: Sturtevant, Felner,
/// Barrer, Schaeffer and Burch, "Memory-based heuristics for explicit state spaces", IJCAI 2009;
/// Goldberg and Harrelson, "Computing the shortest path: A* search meets graph theory", SODA 2005.
///
/// Where obstacles are scattered all over a map, paths are longer than on an empty one by a similar
/// factor everywhere. A landmark behind the goal or the start shows that factor.
///
/// Bounds that hold for a map also hold for each map with fewer passable cells.
class Landmarks {
  public:
    /// Takes two bytes for each landmark and place. There are 16 landmarks, or half as many where
    /// these would take more than `most_bytes`, or none. It is a resumable task. `map` stays
    /// unchanged until all is done. So do the labels of its components, or of those of a map with
    /// fewer passable cells. Memory is kept for the next time.
    ResumableTask build(const GridMap& map, const Components& components, std::size_t most_bytes);

    /// True if the bounds of the map that was built last are known.
    [[nodiscard]] bool known() const { return known_; }

    /// True if the last map needs none: its paths are hardly longer than on an empty map.
    [[nodiscard]] bool needless() const { return needless_; }

    void forget() {
        known_ = false;
        needless_ = false;
    }

    /// Landmarks are needless where paths from one cell to all others are longer than on an empty
    /// map by no more than this share in the mean: searches know that bound without them.
    static constexpr double kNeedlessShare = 0.02;

    /// Towards: the bounds on paths from places to one goal.
    class Towards {
      public:
        Towards(const Landmarks& landmarks, Place goal)
            : far_(landmarks.far_.data()),
              count_(landmarks.count_),
              unit_(landmarks.unit_) {
            std::copy_n(far_ + std::size_t{goal} * count_, count_, goal_far_.begin());
        }

        /// The least cost of the best path from a place of the map; 0 where the place reaches no
        /// landmark.
        [[nodiscard]] Cost least(Place from) const {
            const std::uint16_t* const far = far_ + std::size_t{from} * count_;
            const std::uint16_t most = std::max(
                most_of(far, 0), count_ > kLanes ? most_of(far, kLanes) : std::uint16_t{0});
            // Both distances are rounded down.
            return most > 1 ? (most - Cost{1}) * unit_ : 0;
        }

      private:
        [[nodiscard]] std::uint16_t most_of(const std::uint16_t* far, std::size_t first) const {
            std::uint16_t most = 0;
            for (std::size_t i = first; i < first + kLanes; ++i) {
                const std::uint16_t a = far[i];
                const std::uint16_t b = goal_far_[i];
                const auto off = static_cast<std::uint16_t>(std::max(a, b) - std::min(a, b));
                most = std::max(most, off);
            }
            return most;
        }

        const std::uint16_t* far_;
        std::size_t count_;
        Cost unit_;
        std::array<std::uint16_t, 16> goal_far_{};
    };

    [[nodiscard]] std::size_t bytes() const;

  private:
    static constexpr std::size_t kLanes = 8;
    static constexpr std::size_t kMost = 2 * kLanes;

    std::vector<std::uint16_t> far_;  // by place and landmark, in units
    std::size_t count_ = 0;
    Cost unit_ = 1;
    bool known_ = false;
    bool needless_ = false;
    FlowField field_;
    std::vector<Cost> nearest_;         // by place, of the landmarks so far
    std::vector<std::uint32_t> cells_;  // by component
    double path_sum_ = 0.0;             // costs of the best paths from the first cell,
    double line_sum_ = 0.0;             // and of those on an empty map
};

}  // namespace zoned::ai::pathfinding
