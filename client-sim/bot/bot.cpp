#include "client-sim/bot/bot.h"

#include "proto/sandbox.pb.h"

#include <algorithm>
#include <utility>

namespace zoned::bot {

namespace {

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
        audited_.settle(player_);
        ask_for_audit();
    }
}

void Bot::on_set_back() {
    ++set_backs_;
    audited_.on_set_back(player_);
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
    if (joined() && !quiet_ && view()->own().known()) {
        command = decide(tick, changed);
    }
    if (changed) {
        observer_.on_changed_course(*this, tick);
    }
    return command;
}

bool Bot::may_audit() const {
    return settings_.audit_every_s > 0.0 && (client().rights() & view::Player::kMayAudit) != 0;
}

void Bot::ask_for_audit() {
    if (now_s() < next_audit_look_s_) {
        return;
    }
    next_audit_look_s_ = now_s() + kAuditLookS;
    if (may_audit() && joined() && now_s() - last_audit_s_ >= settings_.audit_every_s) {
        last_audit_s_ = now_s();
        client().request_audit();
    }
}

void Bot::on_session(const wire::WelcomeMessage& /*welcome*/) {
    audited_.on_session(player_);
    ledger_.clear();
    if (view() == nullptr) {
        ++bad_worlds_;
        return;
    }
    spread_audits();
}

void Bot::on_new_view() {
    audited_.on_new_view(player_);
    spread_audits();
}

/// Audit requests of many bots are spread over the interval.
void Bot::spread_audits() {
    last_audit_s_ = now_s() + settings_.audit_every_s *
                                  static_cast<double>(core::mix(settings_.index) % 1024) / 1024.0;
}

void Bot::on_joined(const wire::JoinedMessage& joined) {
    if (!this->joined()) {
        joined_s_ = now_s();
        joined_tick_ = joined.tick;
    }
    audited_.on_joined(player_, joined);
    observer_.on_joined(*this, joined);
}

void Bot::on_event(const wire::EventMessage& event) {
    if (own_script_ != nullptr) {
        own_script_->on_event(event);  // the kinds of its game, which may be the sandbox's numbers
        observer_.on_event(*this, event);
        return;
    }
    if (std::string answer; ledger_.apply(event, avatar(), answer)) {
        client().send_command(sandbox::COMMAND_AGREE, std::move(answer));
    }
    answer_players(event);
    observer_.on_event(*this, event);
}

/// Notes what others hold, and takes an offer for something that this bot holds.
void Bot::answer_players(const wire::EventMessage& event) {
    if (event.kind == sandbox::EVENT_PICK_UP) {
        sandbox::PickedUp picked;
        if (picked.ParseFromString(event.payload) && picked.picker() != avatar().value) {
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
    if (!may_audit()) {
        return;  // the server audits by itself; without a history there is nothing to compare with
    }
    last_audit_s_ = std::max(last_audit_s_, now_s());
    observer_.on_audit(*this, record);
}

void Bot::on_packet(const link::OpenedPacket& packet, const view::PacketResult& taken) {
    audited_.on_packet(player_, packet, taken);
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
