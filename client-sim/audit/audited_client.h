// AuditedClient: what an audit must know of a client beside its view: when its packets came, and
// since when clock and view have settled.
#pragma once

#include "client-sim/link/arrival_log.h"
#include "client-sim/view/player.h"

namespace zoned::audit {

/// Its owner passes on what a player's observer hears.
class AuditedClient {
  public:
    void on_session(const view::Player& player);
    void on_new_view(const view::Player& player);
    void on_joined(const view::Player& player, const wire::JoinedMessage& joined);
    void on_set_back(const view::Player& player);
    void on_packet(const view::Player& player,
                   const link::OpenedPacket& packet,
                   const view::PacketResult& taken);
    /// Call after the player has advanced.
    void settle(const view::Player& player);

    [[nodiscard]] const link::ArrivalLog& arrivals() const { return arrivals_; }

    [[nodiscard]] bool joined() const { return joined_; }

    [[nodiscard]] EntityId avatar() const { return avatar_; }

    /// The first view tick with clock and view settled, after joining and after each time that the
    /// server's clock was set back; -1 before.
    [[nodiscard]] Tick settled_tick() const { return settled_tick_; }

  private:
    link::ArrivalLog arrivals_;
    EntityId avatar_;
    bool joined_ = false;
    double settling_since_s_ = 0.0;
    Tick settled_tick_ = -1;
};

}  // namespace zoned::audit
