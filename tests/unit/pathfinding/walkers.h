// Walkers: characters that follow paths by movement's own function, and worlds for them.
#pragma once

#include "server/ai/pathfinding/grid/ground_map.h"
#include "shared/core/rng.h"

#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// A box of these half extents, turned about `axis` by so many degrees.
motion::StaticBox static_box(const Vec3& centre,
                             const Vec3& half,
                             float degrees = 0.0F,
                             const Vec3& axis = Vec3::UnitY());

/// Walls, crates, ramps, curbs, stairs and a roof, on a square of `side_m` about the origin.
motion::StaticGeometry random_world(core::Rng& rng, float side_m, int pieces);

/// Ticks of 1/30 s that a character takes from the middle of a cell along the corners, at most
/// `most`. It heads for the next corner once it is within `near_m` of this one.
int ticks_to_walk(const motion::StaticGeometry& world,
                  const motion::CharacterLimits& limits,
                  const GroundMap& map,
                  Cell start,
                  std::span<const Spot> corners,
                  float near_m,
                  int most);

}  // namespace zoned::ai::pathfinding
