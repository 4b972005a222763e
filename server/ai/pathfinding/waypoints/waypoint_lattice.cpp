#include "server/ai/pathfinding/waypoints/waypoint_lattice.h"

#include <array>
#include <vector>

namespace zoned::ai::pathfinding {

core::Result<WaypointGraph> waypoint_lattice(const GroundMap& ground) {
    const GridMap& map = ground.cells;
    std::vector<Waypoint> waypoints;
    std::vector<WaypointEdge> edges;
    const auto place_of = [&](Cell c) {
        const Spot at = ground.grid.centre(c);
        return Vec3(at.x, ground.floor_m[map.place(c)], at.z);
    };
    const auto beside = [](Cell c, int dx, int dy) {
        return Cell{static_cast<std::uint16_t>(c.x + dx), static_cast<std::uint16_t>(c.y + dy)};
    };
    for (int y = 0; y < map.height(); ++y) {
        for (int x = 0; x < map.width(); ++x) {
            const Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
            if (!map.passable(c)) {
                continue;
            }
            waypoints.push_back({map.place(c), place_of(c), true});
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    // Places beside the map are not passable.
                    const bool inside =
                        x + dx >= 0 && y + dy >= 0 && x + dx < map.width() && y + dy < map.height();
                    if (!inside || (dx == 0 && dy == 0) || !map.passable(beside(c, dx, dy)) ||
                        !map.passable(beside(c, dx, 0)) || !map.passable(beside(c, 0, dy))) {
                        continue;
                    }
                    const Cell to = beside(c, dx, dy);
                    edges.push_back(
                        {map.place(c), map.place(to), (place_of(to) - place_of(c)).norm()});
                }
            }
        }
    }
    return WaypointGraph::build(waypoints, edges);
}

}  // namespace zoned::ai::pathfinding
