#include "server/zone/context/spawn_points.h"

#include "server/zone/zone_state.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <limits>

namespace zoned::zone {

namespace {

/// To the nearest avatar of a player that this zone knows of, m2.
double room_at(const ZoneState& state, const Vec3d& point) {
    const world::Entities& e = state.entities;
    const Vec3 here = (point - state.settings.region().origin()).cast<float>();
    double room = std::numeric_limits<double>::infinity();
    for (world::Row row = 0; row < e.size(); ++row) {
        if (e.client[row] && !e.has(row, world::kHidden)) {
            room = std::min(room, static_cast<double>((e.position[row] - here).squaredNorm()));
        }
    }
    return room;
}

}  // namespace

std::vector<const SpawnPoint*> spawn_points_of(std::span<const SpawnPoint> points,
                                               std::string_view team) {
    std::vector<const SpawnPoint*> found;
    const auto collect = [&](std::string_view wanted) {
        for (const SpawnPoint& point : points) {
            if (point.team == wanted) {
                found.push_back(&point);
            }
        }
    };
    collect(team);
    if (found.empty()) {
        collect("");
    }
    if (found.empty()) {
        for (const SpawnPoint& point : points) {
            found.push_back(&point);
        }
    }
    return found;
}

const SpawnPoint& freest_spawn_point(const ZoneState& state, std::string_view team) {
    std::vector<const SpawnPoint*> points = spawn_points_of(state.settings.spawn_points, team);
    ZONED_ASSERT(!points.empty(), "a world has a spawn point");
    const auto elsewhere = [&](const SpawnPoint* point) {
        return state.settings.region().outside(point->position.x(), point->position.z()) > 0.0;
    };
    if (!std::all_of(points.begin(), points.end(), elsewhere)) {
        std::erase_if(points, elsewhere);
    }
    const SpawnPoint* best = points.front();
    double best_room = -1.0;
    for (const SpawnPoint* point : points) {
        const double room = room_at(state, point->position);
        if (room > best_room) {
            best = point;
            best_room = room;
        }
    }
    return *best;
}

}  // namespace zoned::zone
