#include "client-sim/bot/bot.h"

#include "proto/sandbox.pb.h"

#include <algorithm>
#include <utility>

namespace zoned::bot {

namespace {

/// Clock and view are given this long to settle before anything is compared.
constexpr double kSettleS = 0.5;
/// A bot looks this often whether an audit is due.
constexpr double kAuditLookS = 0.25;

view::PlayerSettings player_settings(const BotSettings& s) {
    return {s.login, {s.convergence, s.audit_every_s > 0.0, s.view, s.displayed_state, s.meter}};
}

}  // namespace

Bot::Bot(link::Transport& transport,
         view::WorldCache& worlds,
         Observer& observer,
         BotSettings settings)
    : observer_(observer),
      settings_(std::move(settings)),
      script_runner_(settings_.script, settings_.seed, settings_.index, settings_.login.team),
      own_script_(settings_.make_own_script
                      ? settings_.make_own_script(settings_.index, settings_.login.team)
                      : nullptr),
      player_(transport, worlds, *this, player_settings(settings_)) {
}

void Bot::start(double now_s) {
    player_.start(now_s);
}

void Bot::quit(double now_s) {
    player_.quit(now_s);
}

void Bot::advance(double now_s) {
    if (player_.advance(now_s) && player_.ready()) {
        settle();
        ask_for_audit();
    }
}

void Bot::settle() {
    if (settled_tick_ < 0 && joined_ && now_s() - settling_since_s_ > kSettleS) {
        settled_tick_ = view()->tick();
    }
}

void Bot::on_set_back() {
    ++set_backs_;
    arrivals_.set_back(client().clock().server_time(now_s()));
    settling_since_s_ = now_s();
    settled_tick_ = -1;
    observer_.on_set_back(*this);
}

motion::InputCommand Bot::decide(Tick tick, bool& changed) {
    if (own_script_ == nullptr) {
        return script_runner_.decide(*view(), tick, *this, changed);
    }
    const motion::InputCommand before =
        std::exchange(own_command_, own_script_->decide(*view(), tick, *this));
    own_command_.tick = tick;
    changed = changes_course(before, own_command_);
    return own_command_;
}

motion::InputCommand Bot::command_for(Tick tick) {
    motion::InputCommand command;
    bool changed = false;
    if (joined_ && !quiet_ && view()->own().known()) {
        command = decide(tick, changed);
    }
    if (changed) {
        observer_.on_changed_course(*this, tick);
    }
    return command;
}

bool Bot::audited() const {
    return settings_.audit_every_s > 0.0 && (client().rights() & view::Player::kMayAudit) != 0;
}

void Bot::ask_for_audit() {
    if (now_s() < next_audit_look_s_) {
        return;
    }
    next_audit_look_s_ = now_s() + kAuditLookS;
    if (audited() && joined_ && now_s() - last_audit_s_ >= settings_.audit_every_s) {
        last_audit_s_ = now_s();
        client().request_audit();
    }
}

void Bot::on_session(const wire::WelcomeMessage& /*welcome*/) {
    joined_ = false;
    ledger_.clear();
    if (view() == nullptr) {
        ++bad_worlds_;
        settled_tick_ = -1;
        return;
    }
    on_new_view();
}

void Bot::on_new_view() {
    settled_tick_ = -1;
    settling_since_s_ = now_s();
    arrivals_ = {};
    arrivals_.set_tick_s(view()->world().tick_s);
    // Audit requests of many bots are spread over the interval.
    last_audit_s_ = now_s() + settings_.audit_every_s *
                                  static_cast<double>(core::mix(settings_.index) % 1024) / 1024.0;
}

void Bot::on_joined(const wire::JoinedMessage& joined) {
    avatar_ = EntityId(joined.avatar);
    if (!joined_) {
        joined_ = true;
        joined_s_ = now_s();
        settling_since_s_ = now_s();
        joined_tick_ = joined.tick;
    }
    observer_.on_joined(*this, joined);
}

void Bot::on_event(const wire::EventMessage& event) {
    if (own_script_ != nullptr) {
        own_script_->on_event(event);  // the kinds of its game, which may be the sandbox's numbers
        observer_.on_event(*this, event);
        return;
    }
    if (std::string answer; ledger_.apply(event, avatar_, answer)) {
        client().send_command(sandbox::COMMAND_AGREE, std::move(answer));
    }
    answer_players(event);
    observer_.on_event(*this, event);
}

/// Notes what others hold, and takes an offer for something that this bot holds.
void Bot::answer_players(const wire::EventMessage& event) {
    if (event.kind == sandbox::EVENT_PICK_UP) {
        sandbox::PickedUp picked;
        if (picked.ParseFromString(event.payload) && picked.picker() != avatar_.value) {
            script_runner_.note_pick_up(EntityId(picked.picker()), picked.item());
        }
    } else if (event.kind == sandbox::EVENT_OFFER) {
        sandbox::Offer offer;
        const auto items = ledger_.items();
        if (offer.ParseFromString(event.payload) &&
            std::find(items.begin(), items.end(), offer.want()) != items.end()) {
            client().send_command(sandbox::COMMAND_ACCEPT, event.payload);
        }
    }
}

void Bot::on_audit(const wire::AuditRecordMessage& record) {
    if (!audited()) {
        return;  // the server audits by itself; without a history there is nothing to compare with
    }
    last_audit_s_ = std::max(last_audit_s_, now_s());
    observer_.on_audit(*this, record);
}

void Bot::on_packet(const link::OpenedPacket& packet, const view::PacketResult& taken) {
    // An unreadable packet counts as not arrived.
    if (taken.read && client().clock().ready()) {
        // On the view's own clock, which stands still when the estimate of the server's is set
        // back a little: the number of ticks shown without this update counts.
        const double shown_s = static_cast<double>(view()->tick()) * view()->world().tick_s;
        arrivals_.on_packet(packet.sequence,
                            packet.head.tick,
                            std::max(client().clock().server_time(now_s()), shown_s),
                            packet.head.widened);
    }
    if (taken.correction.compared) {
        observer_.on_correction(*this, taken.correction.tick, taken.correction.distance_m);
    }
}

void Bot::on_shown(EntityId entity, Tick publication_tick, Tick from_tick) {
    observer_.on_shown(*this, entity, publication_tick, from_tick);
}

void Bot::command(std::uint32_t kind, std::string payload) {
    client().send_command(kind, std::move(payload));
}

}  // namespace zoned::bot
