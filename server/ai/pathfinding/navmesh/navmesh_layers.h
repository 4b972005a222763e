// Navmesh layers: on which floors of which columns of a world a character can walk, by Recast's
// rules.
#pragma once

#include "server/ai/pathfinding/grid/ground_grid.h"
#include "shared/core/result.h"
#include "shared/motion/apply_input.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::pathfinding {

/// Columns and steps of height in which a world is looked at, and the body in these.
struct FloorFrame {
    GroundGrid grid;
    float low_m = 0.0F;   ///< of the lowest step
    float high_m = 0.0F;  ///< nothing is higher
    float step_m = 0.05F;
    int height_steps = 1;  ///< of the body
    int climb_steps = 0;
    int radius_cells = 0;
};

/// Empty, or why the heights of a world can't be counted in such steps.
std::string frame_defect(const FloorFrame& frame);

/// `world` with its doors, which may be the highest that there is.
FloorFrame floor_frame(const motion::StaticGeometry& world,
                       const motion::CharacterLimits& limits,
                       const GroundRect& area,
                       float cell_m,
                       float step_m);

/// A floor of a column, in steps above FloorFrame::low_m.
struct NavmeshFloor {
    std::uint16_t y = 0;
    std::uint8_t room = 0;  ///< above it, at most 255
};

/// By column (row by row), floors upwards.
struct NavmeshLayers {
    std::vector<std::uint32_t> first;  ///< by column, and one more
    std::vector<NavmeshFloor> floors;

    [[nodiscard]] std::span<const NavmeshFloor> column(std::size_t c) const {
        return {floors.data() + first[c], floors.data() + first[c + 1]};
    }
};

/// Of a world with none of its doors shut, the middle of the body as far from walls and edges as it
/// is wide. Fails where Recast has no room.
core::Result<NavmeshLayers> navmesh_layers(const motion::StaticGeometry& world,
                                           const motion::CharacterLimits& limits,
                                           const FloorFrame& frame);

}  // namespace zoned::ai::pathfinding
