// GroundMap: where characters of one size can walk in a zone, baked from its solid geometry.
#pragma once

#include "server/ai/pathfinding/grid/ground_grid.h"
#include "shared/motion/apply_input.h"

#include <vector>

namespace zoned::ai::pathfinding {

/// Each cell has one floor. Of the floors on which the capsule stands, it is the highest that can
/// be reached from the largest part of the ground; else it is the lowest. So paths lead over a
/// bridge and up a ramp, not below them. Space under a roof is ground unless stairs lead onto the
/// roof. No floor lies below a height grid.
struct GroundMap {
    GroundGrid grid;
    GridMap cells;
    /// The height of the capsule's lowest point in the middle of a cell, m; by place. 0 where
    /// blocked.
    std::vector<float> floor_m;
};

/// Bakes the cells in whose middle the capsule stands free on a carrying floor.
/// The test is movement's own: motion::CapsuleSweep puts the capsule down. Where something is near,
/// a step between cells counts if motion::apply_input makes it, from the lower to the higher. Over
/// heights all of whose triangles carry, steps need no trial.
/// Where a step cannot be made, the higher of both cells is blocked (of two as high, the one with
/// the smaller place). So paths keep away from edges that are too high. Each step of a path can be
/// walked in either direction, but a step down off a ledge may be a jump of more than step_down.
/// On rough heights a walker may slide off its line beside a face that is too steep; then it has to
/// ask again.
/// Each size of character has its own map. GroundGrid::defect_of() must be empty.
GroundMap bake_ground(const motion::StaticGeometry& world,
                      const motion::CharacterLimits& limits,
                      const GroundRect& area,
                      float cell_m);

}  // namespace zoned::ai::pathfinding
