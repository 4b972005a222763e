#include "server/app/world/portal_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::app {

namespace {

/// When somebody who moves on like this is in the box (slabs: T. Kay and J. Kajiya, "Ray tracing
/// complex scenes", 1986, section 3), s; infinity: at no time.
double seconds_to(const config::PortalSettings& box, const Vec3d& position, const Vec3d& velocity) {
    double enters = 0.0;
    double leaves = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const double below = box.lower_m[a] - position[axis];
        const double above = box.upper_m[a] - position[axis];
        if (velocity[axis] == 0.0) {
            enters = below > 0.0 || above < 0.0 ? std::numeric_limits<double>::infinity() : enters;
            continue;
        }
        const double s = below / velocity[axis];
        const double t = above / velocity[axis];
        enters = std::max(enters, std::min(s, t));
        leaves = std::min(leaves, std::max(s, t));
    }
    return enters <= leaves ? enters : std::numeric_limits<double>::infinity();
}

}  // namespace

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

/// The portal that is entered first within kAhead_s; number of portals: none.
std::size_t PortalWatch::portal_ahead(const Vec3d& position, const Vec3d& velocity) const {
    std::size_t first = portals_.size();
    double soonest_s = kAhead_s;
    for (std::size_t portal = 0; portal < portals_.size(); ++portal) {
        const double s = seconds_to(portals_[portal], position, velocity);
        if (s <= soonest_s) {
            soonest_s = s;
            first = portal;
        }
    }
    return first;
}

void PortalWatch::announce(ClientId client,
                           std::size_t portal,
                           Tick now,
                           std::vector<TravelAhead>& ahead) {
    const auto [it, fresh] = announced_.try_emplace(client);
    if (fresh || it->second.portal != portal || now >= it->second.until) {
        const auto ticks = static_cast<Tick>(std::ceil(kAnnounceEvery_s * tick_rate_hz_));
        it->second = {portal, now + ticks};
        ahead.push_back({client, portals_[portal].to_world});
    }
}

void PortalWatch::look(const World& world,
                       std::vector<TravelWish>& out,
                       std::vector<TravelAhead>& ahead) {
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
            const Vec3d position = origin + state.entities.position[row].cast<double>();
            const std::size_t portal = portal_at(position);
            const std::size_t next =
                portal < portals_.size()
                    ? portal
                    : portal_ahead(position, state.entities.velocity[row].cast<double>());
            if (next < portals_.size()) {
                announce(client.client, next, now, ahead);
            }
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
    std::erase_if(announced_, [now](const auto& entry) { return now >= entry.second.until; });
}

}  // namespace zoned::app
