// Spawn points: where players may appear, by name and team.
#pragma once

#include "shared/math/types.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::zone {

struct ZoneState;

struct SpawnPoint {
    Vec3d position = Vec3d::Zero();  ///< world coordinates, of an avatar's centre, m
    std::string name;                ///< may be empty
    std::string team;                ///< empty: of all
};

/// The points of a team, in their order. Where it has none, those of no team; where there are none
/// of these either, all.
[[nodiscard]] std::vector<const SpawnPoint*> spawn_points_of(std::span<const SpawnPoint> points,
                                                             std::string_view team);

/// Of the points of a team, that from which the nearest player's avatar is farthest, the first of
/// equals: in this zone, or anywhere where the team has no point here.
[[nodiscard]] const SpawnPoint& freest_spawn_point(const ZoneState& state, std::string_view team);

}  // namespace zoned::zone
