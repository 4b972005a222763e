// GroundMap: where characters of one size can walk in a zone, baked from what is solid there.
#pragma once

#include "server/ai/pathfinding/grid/ground_grid.h"
#include "shared/motion/apply_input.h"

#include <vector>

namespace zoned::ai::pathfinding {

/// One floor to a cell: of those on which the capsule stands the highest that can be walked to from
/// the largest part of the ground (over a bridge and up a ramp, not below them), else the lowest.
/// So what lies under a roof is ground unless stairs lead onto the roof. Never below a height grid.
struct GroundMap {
    GroundGrid grid;
    GridMap cells;
    /// Height of the capsule's lowest point in the middle of a cell, m; by place. 0 where blocked.
    std::vector<float> floor_m;
};

/// Cells in whose middle the capsule stands free on what carries it. The test is movement's own:
/// the capsule is put down by motion::CapsuleSweep, and wherever something is near, a step from a
/// cell to the next counts if motion::apply_input makes it, from the lower to the higher. Where a
/// step can't be made, the higher of both cells is blocked (of two as high, that with the smaller
/// place): so paths keep away from edges that are too high, and each step of a path can be walked
/// in either direction, but that one down off a ledge may be a jump of more than step_down. Over
/// heights all of whose triangles carry, steps need no trial. On rough heights a walker may slide
/// off its line beside a face that is too steep; then it has to ask again. Several sizes of
/// characters have a map each. GroundGrid::defect_of() is empty.
GroundMap bake_ground(const motion::StaticGeometry& world,
                      const motion::CharacterLimits& limits,
                      const GroundRect& area,
                      float cell_m);

}  // namespace zoned::ai::pathfinding
