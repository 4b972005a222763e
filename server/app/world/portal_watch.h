// PortalWatch: looks after each tick for avatars that stand in a portal. It changes nothing of the
// world, so a recording needs to know nothing of it.
#pragma once

#include "server/app/world/world.h"
#include "server/config/server_settings.h"

#include <cstdint>
#include <map>
#include <vector>

namespace zoned::app {

using zone::TravelWish;

class PortalWatch {
  public:
    PortalWatch(const std::vector<config::PortalSettings>& portals, double tick_rate_hz);

    /// Avatars that have stood in a portal for as long as it asks for are to leave, again each
    /// second in which they are still there.
    void look(const World& world, std::vector<TravelWish>& out);

  private:
    struct Standing {
        std::size_t portal = 0;
        Tick wish_at = 0;
        Tick seen = 0;
    };

    [[nodiscard]] std::size_t portal_at(const Vec3d& position) const;

    const std::vector<config::PortalSettings>& portals_;
    double tick_rate_hz_;
    std::map<ClientId, Standing> standing_;
};

}  // namespace zoned::app
