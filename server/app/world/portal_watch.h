// PortalWatch: looks after each tick for avatars that stand in a portal or come near to one. It
// changes nothing of the world, so a recording needs to know nothing of it.
#pragma once

#include "server/app/world/world.h"
#include "server/config/server_settings.h"

#include <cstdint>
#include <map>
#include <vector>

namespace zoned::app {

using zone::TravelWish;

/// A player who comes near to a portal.
struct TravelAhead {
    ClientId client;
    std::string world;
};

class PortalWatch {
  public:
    PortalWatch(const std::vector<config::PortalSettings>& portals, double tick_rate_hz);

    /// Avatars that have stood in a portal for as long as it asks for are to leave, again each
    /// second in which they are still there. Those that are about to be in one, or wait in one, are
    /// ahead, once in kAnnounceEvery_s.
    void look(const World& world, std::vector<TravelWish>& out, std::vector<TravelAhead>& ahead);

    /// By its velocity an avatar is in a portal so soon: time for a name, a connection and TLS.
    static constexpr double kAhead_s = 3.0;
    /// The way there may be known later only, and servers close a connection without a login:
    /// clients that are connected do nothing.
    static constexpr double kAnnounceEvery_s = 0.75;

  private:
    struct Standing {
        std::size_t portal = 0;
        Tick wish_at = 0;
        Tick seen = 0;
    };

    struct Announced {
        std::size_t portal = 0;
        Tick until = 0;
    };

    [[nodiscard]] std::size_t portal_at(const Vec3d& position) const;
    [[nodiscard]] std::size_t portal_ahead(const Vec3d& position, const Vec3d& velocity) const;
    void announce(ClientId client, std::size_t portal, Tick now, std::vector<TravelAhead>& ahead);

    const std::vector<config::PortalSettings>& portals_;
    double tick_rate_hz_;
    std::map<ClientId, Standing> standing_;
    std::map<ClientId, Announced> announced_;
};

}  // namespace zoned::app
