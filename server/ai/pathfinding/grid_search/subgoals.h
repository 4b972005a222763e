// Subgoals: the cells at corners of obstacles, their mutual visibility, and other cells' doors.
#pragma once

#include "server/ai/pathfinding/grid/cost.h"
#include "server/ai/pathfinding/grid/grid_map.h"
#include "server/ai/pathfinding/grid_search/resumable_task.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

using Subgoal = std::uint32_t;

inline constexpr Subgoal kNoSubgoal = ~Subgoal{0};

/// Simple subgoal graph. Source: Uras, Koenig and Hernandez, "Subgoal graphs for optimal
/// pathfinding in eight-neighbor grids", ICAPS 2013. A subgoal is a passable cell that touches a
/// blocked one across a corner that can be walked around. Consider all paths between two subgoals
/// that are as short as on an empty map. The two see each other where all of these are free and
/// none passes a third subgoal. A best path between subgoals leads along such pairs (theorem 1
/// there).
///
/// Other cells keep only their doors, which are far fewer. Doors are the jump points that the
/// straight rays from a cell, and from the cells on its diagonals, meet first. Source: Harabor and
/// Grastien, "Online graph pruning for pathfinding on grid maps", AAAI 2011; without cutting
/// corners diagonals have none of their own.
///
/// From a to b either the path along the diagonal first and then straight is free, or some best
/// path leads through a door t of a. Then from b to t either that path is free, or some best path
/// leads through a door u of b. So the best path is free_line(a, b), or a - t - b with free_line(b,
/// t), or a - t - u - b.
class Subgoals {
  public:
    /// Builds from the map as it is. Nothing where all cells together have more than `most_doors`.
    static std::optional<Subgoals> build(const GridMap& map, std::size_t most_doors);

    /// The same as a resumable task. `map` stays unchanged, and `built` in place, until all is
    /// done.
    static ResumableTask build(const GridMap& map,
                               std::size_t most_doors,
                               std::optional<Subgoals>& built);

    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(cells_.size()); }

    [[nodiscard]] Cell cell(Subgoal s) const { return cells_[s]; }

    /// The doors of a passable place.
    [[nodiscard]] std::span<const Subgoal> doors(Place p) const {
        return {doors_.data() + first_door_[p], doors_.data() + first_door_[p + 1]};
    }

    /// The subgoals that a subgoal sees.
    [[nodiscard]] std::span<const Subgoal> neighbours(Subgoal s) const {
        return {seen_.data() + first_seen_[s], seen_.data() + first_seen_[s + 1]};
    }

    /// The number of visible pairs, of all subgoals together.
    [[nodiscard]] std::size_t edges() const { return seen_.size(); }

    /// The subgoal at a place; kNoSubgoal where there is none.
    [[nodiscard]] Subgoal at(Place p) const;

    /// The cost between cells as on an empty map.
    [[nodiscard]] Cost cost(Subgoal a, Subgoal b) const { return cost(cells_[a], b); }

    [[nodiscard]] Cost cost(Cell a, Subgoal b) const {
        return octile(cells_[b].x - a.x, cells_[b].y - a.y);
    }

    [[nodiscard]] std::size_t bytes() const;

  private:
    Subgoals() = default;

    std::vector<Cell> cells_;
    std::vector<Place> place_;               // ascending
    std::vector<std::uint32_t> first_seen_;  // by subgoal, and one more
    std::vector<Subgoal> seen_;
    std::vector<std::uint32_t> first_door_;  // by place, and one more
    std::vector<Subgoal> doors_;
};

}  // namespace zoned::ai::pathfinding
