#include "client-sim/audit/audited_client.h"

#include <algorithm>

namespace zoned::audit {

namespace {

/// Clock and view are given this long to settle before anything is compared.
constexpr double kSettleS = 0.5;

}  // namespace

void AuditedClient::on_session(const view::Player& player) {
    joined_ = false;
    settled_tick_ = -1;
    if (player.view() != nullptr) {
        on_new_view(player);
    }
}

void AuditedClient::on_new_view(const view::Player& player) {
    settled_tick_ = -1;
    settling_since_s_ = player.now_s();
    arrivals_ = {};
    arrivals_.set_tick_s(player.view()->world().tick_s);
}

void AuditedClient::on_joined(const view::Player& player, const wire::JoinedMessage& joined) {
    avatar_ = EntityId(joined.avatar);
    if (!joined_) {
        joined_ = true;
        settling_since_s_ = player.now_s();
    }
}

void AuditedClient::on_set_back(const view::Player& player) {
    arrivals_.set_back(player.client().clock().server_time(player.now_s()));
    settling_since_s_ = player.now_s();
    settled_tick_ = -1;
}

void AuditedClient::on_packet(const view::Player& player,
                              const link::OpenedPacket& packet,
                              const view::PacketResult& taken) {
    // An unreadable packet counts as not arrived.
    if (!taken.read || !player.client().clock().ready()) {
        return;
    }
    // On the view's own clock, which stands still when the estimate of the server's is set back a
    // little: the number of ticks shown without this update counts.
    const view::View& view = *player.view();
    const double shown_s = static_cast<double>(view.tick()) * view.world().tick_s;
    arrivals_.on_packet(packet.sequence,
                        packet.head.tick,
                        std::max(player.client().clock().server_time(player.now_s()), shown_s),
                        packet.head.widened);
}

void AuditedClient::settle(const view::Player& player) {
    if (settled_tick_ < 0 && joined_ && player.now_s() - settling_since_s_ > kSettleS) {
        settled_tick_ = player.view()->tick();
    }
}

}  // namespace zoned::audit
