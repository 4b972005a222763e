#include "server/zone/border/zone_portal_exchange.h"

#include "server/ai/pathfinding/requests/zone_portals.h"
#include "server/zone/zone_state.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

namespace zoned::zone {

void join_paths(std::span<ZoneState* const> all) {
    std::vector<ZoneState*> zones;  // nobody walks into a copy for instances
    std::copy_if(all.begin(), all.end(), std::back_inserter(zones), [](const ZoneState* zone) {
        return zone->settings.first_state == nullptr;
    });
    if (zones.size() < 2) {
        for (ZoneState* zone : zones) {
            zone->paths.forget_ground();
        }
        return;
    }
    for (std::size_t size = 0; size < zones.front()->paths.sizes(); ++size) {
        if (zones.front()->paths.ground_map(size) == nullptr) {
            continue;  // portals are made of cells alone
        }
        std::vector<ai::pathfinding::ZoneGround> grounds;
        for (const ZoneState* zone : zones) {
            const Region& region = zone->settings.region();
            const Vec3d origin = region.origin();
            const auto half_x = static_cast<float>(0.5 * (region.max_x - region.min_x));
            const auto half_z = static_cast<float>(0.5 * (region.max_z - region.min_z));
            grounds.push_back({zone->paths.ground_map(size),
                               origin.x(),
                               origin.z(),
                               ai::pathfinding::GroundRect{-half_x, -half_z, half_x, half_z}});
        }
        auto portals = std::make_shared<const ai::pathfinding::ZonePortals>(grounds);
        for (std::uint32_t z = 0; z < zones.size(); ++z) {
            zones[z]->paths.know_zones(size, portals, z);
        }
    }
}

}  // namespace zoned::zone
