// NextHops: packed hops to goals that are requested often.
// Reached by no program yet: next hops embedded in map data will use it.
#pragma once

#include "server/ai/pathfinding/flow_fields/flow_field.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::ai::pathfinding {

/// Hops to common goals, at half a byte for each cell of the map and goal.
class NextHops {
  public:
    explicit NextHops(const GridMap& map) : width_(map.width()), height_(map.height()) {}

    /// The number of the goal that `field` leads to on this map: 0, 1, ...
    std::size_t add(const GridMap& map, const FlowField& field);

    /// The hop from a cell of the map.
    [[nodiscard]] Hop hop(std::size_t goal, Cell c) const {
        const std::size_t at =
            c.y * static_cast<std::size_t>(width_) + static_cast<std::size_t>(c.x);
        return static_cast<Hop>(hops_[goal * bytes_per_goal() + at / 2] >> (at % 2 * 4) & 15U);
    }

    [[nodiscard]] std::size_t bytes_per_goal() const {
        return (static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) + 1) / 2;
    }

    [[nodiscard]] std::size_t bytes() const { return hops_.size(); }

  private:
    int width_;
    int height_;
    std::vector<std::uint8_t> hops_;
};

}  // namespace zoned::ai::pathfinding
