// Navmesh layers: the floors of a world's columns on which a character can walk, by Recast's rules.
#pragma once

#include "server/ai/pathfinding/grid/ground_grid.h"
#include "shared/core/result.h"
#include "shared/motion/apply_input.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::pathfinding {

/// FloorFrame: the columns and steps of height into which a world is divided, and the body in these
/// units.
struct FloorFrame {
    GroundGrid grid;
    float low_m = 0.0F;   ///< height of the lowest step
    float high_m = 0.0F;  ///< upper bound of all heights
    float step_m = 0.05F;
    int height_steps = 1;  ///< height of the body
    int climb_steps = 0;
    int radius_cells = 0;
};

/// Empty, or the reason why the world's heights cannot be counted in such steps.
std::string frame_defect(const FloorFrame& frame);

/// Takes `world` with its doors, which may be its highest parts.
FloorFrame floor_frame(const motion::StaticGeometry& world,
                       const motion::CharacterLimits& limits,
                       const GroundRect& area,
                       float cell_m,
                       float step_m);

/// A floor of a column, in steps above FloorFrame::low_m.
struct NavmeshFloor {
    std::uint16_t y = 0;
    std::uint8_t room = 0;  ///< free space above it, at most 255
};

/// Floors by column (row by row), from below upwards.
struct NavmeshLayers {
    std::vector<std::uint32_t> first;  ///< by column, and one more
    std::vector<NavmeshFloor> floors;

    [[nodiscard]] std::span<const NavmeshFloor> column(std::size_t c) const {
        return {floors.data() + first[c], floors.data() + first[c + 1]};
    }
};

/// The layers of a world with no doors shut. They keep the middle of the body one body radius away
/// from walls and edges. Fails where Recast has no room.
core::Result<NavmeshLayers> navmesh_layers(const motion::StaticGeometry& world,
                                           const motion::CharacterLimits& limits,
                                           const FloorFrame& frame);

}  // namespace zoned::ai::pathfinding
