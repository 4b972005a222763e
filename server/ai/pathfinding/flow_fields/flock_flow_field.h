// FlockFlowField: directions over the ground that steer a flock, along a path or to a goal.
// Reached by no program yet: flocking of large herds on a device will use it.
#pragma once

#include "server/ai/pathfinding/flow_fields/flow_field.h"
#include "server/ai/pathfinding/grid/grid_map.h"
#include "kernels/include/flock.h"
#include "shared/math/types.h"

#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// A table of directions, as compute::FlockStage::step takes it.
struct FlockFlowField {
    float x0 = 0.0F;  ///< m, of the first cell's corner
    float z0 = 0.0F;
    float cell_m = 1.0F;
    int columns = 0;
    int rows = 0;
    std::vector<float> directions;  ///< x and z of each cell, row by row

    /// Writes the table's position into the rules; `follow` (1/s, > 0): how fast the flock turns.
    void steer(kernels::FlockRules& rules, float follow) const;
};

/// Directions along a path of two or more points (x, z in m). Each cell of the rectangle gets the
/// direction of the nearest piece, turned towards that piece. The turn is half a right angle at a
/// distance of `width_m` (> 0) and almost a right angle farther off. At the end of the path
/// directions lead to its end.
FlockFlowField along_path(std::span<const Vec2> path,
                          const FlockFlowField& rectangle,
                          float width_m);

/// Directions by the steps of a field to a goal on a grid map. The first cell's corner is at (x0,
/// z0), and cells have `cell_m`. They are zero where there is no path and at the goal: there only
/// the other animals steer.
FlockFlowField to_goal(const GridMap& map,
                       const FlowField& field,
                       float x0,
                       float z0,
                       float cell_m);

}  // namespace zoned::ai::pathfinding
