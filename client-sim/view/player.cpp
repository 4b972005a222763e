#include "client-sim/view/player.h"

#include "shared/clock/tick_clock.h"

#include <algorithm>
#include <utility>

namespace zoned::view {

namespace {

/// A player without a settled clock looks again this often.
constexpr double kIdlePollS = 0.02;
/// Until its clock is set a player sends an empty input packet this often.
constexpr double kProbeS = 0.05;
constexpr double kMaintenanceS = 0.25;

}  // namespace

Player::Player(link::Transport& transport,
               WorldCache& worlds,
               PlayerListener& listener,
               PlayerSettings settings)
    : worlds_(worlds),
      listener_(listener),
      settings_(settings.view),
      client_(transport, *this, std::move(settings.login)) {
}

void Player::start(double now_s) {
    now_s_ = now_s;
    client_.start(now_s);
}

void Player::quit(double now_s) {
    now_s_ = now_s;
    client_.quit(now_s);
}

bool Player::ready() const {
    return view_ && client_.state() == link::SessionState::kOnline && client_.clock().ready();
}

bool Player::advance(double now_s) {
    if (now_s < next_wake_s_ && !client_.has_incoming()) {
        return false;
    }
    now_s_ = now_s;
    // Evaluate all work due before this update without it: an audit of tick T must find the screen
    // of T.
    evaluate();
    client_.advance(now_s);
    next_wake_s_ = now_s + kIdlePollS;
    if (!ready()) {
        probe();
        return true;
    }
    evaluate();
    inputs_.advance(
        client_, view_->own(), now_s, [this](Tick tick) { return listener_.command_for(tick); });
    housekeeping();
    const double next_tick_s = static_cast<double>(view_->tick() + 1) * view_->world().tick_s -
                               client_.clock().server_time(now_s);
    const double next_input_s = inputs_.due_in_s(client_, now_s);
    next_wake_s_ = now_s + std::clamp(std::min(next_tick_s, next_input_s), 0.0, kIdlePollS);
    return true;
}

/// Without acks there is no clock: an empty input packet starts the exchange.
void Player::probe() {
    if (view_ && client_.state() == link::SessionState::kOnline && now_s_ >= next_probe_s_) {
        next_probe_s_ = now_s_ + kProbeS;
        client_.send_input({}, now_s_);
    }
}

void Player::evaluate() {
    if (!view_ || !client_.clock().ready()) {
        return;
    }
    const double tick_s = view_->world().tick_s;
    const Tick present =
        clock::TickClock(1.0 / tick_s).tick_at(client_.clock().server_time(now_s_));
    // A server that stood still drops the ticks that it can't catch up with (TickSchedule). Its
    // clients predicted them all the same, and would show a standing world until it comes to them.
    if (static_cast<double>(view_->tick() - present) * tick_s > kSetBackS) {
        view_->set_back(present);
        inputs_.set_back();
        listener_.on_set_back();
    }
    view_->evaluate(present);
}

double Player::tick_fraction(double now_s) const {
    const double present = client_.clock().server_time(now_s) / view_->world().tick_s;
    return std::clamp(present - static_cast<double>(view_->tick()), 0.0, 1.0);
}

void Player::housekeeping() {
    if (const std::string wish = view_->take_reset_wish(now_s_); !wish.empty()) {
        client_.reset_view(wish);
    }
    if (now_s_ >= next_maintenance_s_) {
        next_maintenance_s_ = now_s_ + kMaintenanceS;
        view_->maintain(now_s_);
    }
}

void Player::on_welcome(const wire::WelcomeMessage& welcome) {
    if (welcome.resumed) {
        if (welcome.recovered && view_) {
            const std::unique_ptr<View> before = std::move(view_);
            begin_view(welcome.rights);
            view_->go_on_with(*before);
            listener_.on_new_view();
        }
        return;
    }
    bad_world_ = welcome.world ? "" : "the server sent no world";
    world_ =
        welcome.world ? worlds_.get(welcome.config_digest, *welcome.world, bad_world_) : nullptr;
    view_.reset();
    if (world_) {
        begin_view(welcome.rights);
    }
    listener_.on_session(welcome);
}

void Player::begin_view(std::uint32_t rights) {
    ViewSettings settings = settings_;
    settings.keep_history = settings.keep_history && (rights & kMayAudit) != 0;
    view_ = std::make_unique<View>(world_, settings, &listener_);
    inputs_.restart(world_->tick_s);
}

void Player::on_joined(const wire::JoinedMessage& joined) {
    listener_.on_joined(joined);
}

void Player::on_event(const wire::EventMessage& event) {
    if (view_) {
        view_->apply(event);
    }
    listener_.on_event(event);
}

void Player::on_audit(const wire::AuditRecordMessage& record) {
    listener_.on_audit(record);
}

bool Player::on_packet(const link::OpenedPacket& packet) {
    if (!view_) {
        return false;
    }
    packet_sent_s_ = packet.server_send_s;
    inputs_.on_path_answers(client_);
    const PacketResult taken = view_->apply(packet, now_s_);
    if (taken.correction.applied) {
        inputs_.on_report(packet.head.own, client_.clock().rtt_s());
    }
    listener_.on_packet(packet, taken);
    return taken.read;
}

}  // namespace zoned::view
