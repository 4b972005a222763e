// Flock: the heading of a herd animal from its neighbours.
#pragma once

#include "server/spatial/point_grid.h"
#include "server/world/entities.h"

#include <span>

namespace zoned::ai {

/// Distance under which herd animals turn away from each other, as a share of the flock's radius.
inline constexpr float kSeparationShare = 0.25F;

struct FlockQuery {
    world::Row self = world::kNoRow;
    Vec2 home = Vec2::Zero();  ///< x, z, m
    /// Along a way, unit length; zero: it is drawn home instead.
    Vec2 way = Vec2::Zero();
    Vec2 heading = Vec2::Zero();  ///< own direction now: unit length, or zero when it stands
    float radius_m = 20.0F;       ///< who counts as a neighbour
    float speed = 1.0F;           ///< m/s, full speed of the gait, > 0
};

/// Separation, alignment and cohesion (Reynolds, "Flocks, herds, and schools: a distributed
/// behavioral model", SIGGRAPH 1987, as weighted sums) over the entities of the same type, plus a
/// pull towards home that grows with distance, or along a way, and some inertia. Not normalised;
/// may be zero. The sums are integers, so that they do not depend on the order of rows. The
/// direction at `here` along the round trip of `stops` (1 or more): of the nearest piece, turned
/// towards it, by half a right angle at a distance of `width_m` (> 0) and by almost a right one
/// farther off, as crowd::along_path. One stop: towards it; zero within `width_m` of it.
Vec2 round_trip(std::span<const Vec2> stops, const Vec2& here, float width_m);

Vec2 flock_heading(const world::Entities& entities,
                   const spatial::PointGrid& grid,
                   const FlockQuery& query);

}  // namespace zoned::ai
