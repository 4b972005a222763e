// Flock path: the directions over the ground that lead a flock along its path.
#pragma once

#include "server/physics/particles/particle_flock.h"

#include <vector>

namespace zoned::physics {

/// x and z of a vector of length 1 or 0 for each cell, row by row. The table covers the flock's
/// home; its place and size go into `rules`, its cells are a quarter of the path's width where that
/// makes at most kMostPathCells along a side. Each cell gets the direction of the nearest piece of
/// the path, turned towards that piece: by half a right angle at a distance of path_width, by
/// almost a right angle farther off. At the end of a path that is not closed directions lead to the
/// end.
std::vector<float> directions_along(const FlockDef& def, kernels::FlockRules& rules);

inline constexpr int kMostPathCells = 256;

}  // namespace zoned::physics
