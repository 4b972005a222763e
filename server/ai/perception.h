// Perception: what a mind notices of the players around it.
#pragma once

#include "server/spatial/point_grid.h"
#include "server/world/entities.h"

#include <limits>

namespace zoned::ai {

struct Sight {
    EntityId prey;           ///< the nearest player within perception, or none
    float distance = 0.0F;   ///< to it, horizontally, m; infinity when there is none
    bool player_far = true;  ///< no player within far_m

    /// Nobody is there.
    static Sight none() { return {EntityId(), std::numeric_limits<float>::infinity(), true}; }
};

/// Players are the rows with a client that are not hidden, ghosts included; `self` is not a player
/// to itself. Of players equally near the one with the smaller id counts, whatever the order of
/// rows. Radii in m, > 0.
Sight look(const world::Entities& entities,
           const spatial::PointGrid& grid,
           world::Row self,
           float perception_m,
           float far_m);

}  // namespace zoned::ai
