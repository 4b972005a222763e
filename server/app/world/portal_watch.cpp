#include "server/app/world/portal_watch.h"

#include <cmath>

namespace zoned::app {

PortalWatch::PortalWatch(const std::vector<config::PortalSettings>& portals, double tick_rate_hz)
    : portals_(portals),
      tick_rate_hz_(tick_rate_hz) {
}

/// Number of portals: in none.
std::size_t PortalWatch::portal_at(const Vec3d& position) const {
    std::size_t portal = 0;
    const auto outside = [&](const config::PortalSettings& box) {
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            if (position[axis] < box.lower_m[a] || position[axis] > box.upper_m[a]) {
                return true;
            }
        }
        return false;
    };
    while (portal < portals_.size() && outside(portals_[portal])) {
        ++portal;
    }
    return portal;
}

void PortalWatch::look(const World& world, std::vector<TravelWish>& out) {
    const Tick now = world.now();
    for (const auto& zone : world.zones()) {
        const zone::ZoneState& state = zone->state();
        if (state.frozen) {
            // Nobody goes anywhere in a world that stands still; nobody's time in a box runs out.
            return;
        }
        const Vec3d origin = state.settings.region().origin();
        for (const zone::ZoneClient& client : state.clients) {
            const world::Row row = state.entities.find(client.avatar);
            if (row == world::kNoRow || state.entities.has(row, world::kHidden)) {
                continue;
            }
            const std::size_t portal =
                portal_at(origin + state.entities.position[row].cast<double>());
            if (portal == portals_.size()) {
                continue;
            }
            const auto [it, fresh] = standing_.try_emplace(client.client);
            Standing& standing = it->second;
            if (fresh || standing.portal != portal) {
                standing.portal = portal;
                standing.wish_at =
                    now + static_cast<Tick>(std::ceil(portals_[portal].wait_s * tick_rate_hz_));
            }
            standing.seen = now;
            if (now >= standing.wish_at) {
                standing.wish_at = now + static_cast<Tick>(std::ceil(tick_rate_hz_));
                out.push_back({client.client, portals_[portal].to_world, portals_[portal].arrival});
            }
        }
    }
    std::erase_if(standing_, [now](const auto& entry) { return entry.second.seen != now; });
}

}  // namespace zoned::app
