#include "client-sim/bot/bot.h"

#include "proto/sandbox.pb.h"
#include "shared/clock/tick_clock.h"
#include "shared/wire/packet.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::bot {

namespace {

/// A bot without a settled clock looks again this often.
constexpr double kIdlePollS = 0.02;
/// Until its clock is set a bot sends an empty input packet this often.
constexpr double kProbeS = 0.05;
/// Clock and view are given this long to settle before anything is compared.
constexpr double kSettleS = 0.5;
/// Rounding of seconds counted in ticks.
constexpr double kSameTick = 1e-6;

}  // namespace

Bot::Bot(link::Transport& transport,
         view::WorldCache& worlds,
         Observer& observer,
         BotSettings settings)
    : worlds_(worlds),
      observer_(observer),
      settings_(std::move(settings)),
      script_runner_(settings_.script, settings_.seed, settings_.index, settings_.login.team),
      client_(transport, *this, settings_.login) {
}

void Bot::start(double now_s) {
    now_s_ = now_s;
    client_.start(now_s);
}

void Bot::quit(double now_s) {
    now_s_ = now_s;
    client_.quit(now_s);
}

void Bot::advance(double now_s) {
    if (now_s < next_wake_s_ && !client_.has_incoming()) {
        return;
    }
    now_s_ = now_s;
    // Evaluate all work due before this update without it: an audit of tick T must find the screen
    // of T.
    evaluate();
    client_.advance(now_s);
    next_wake_s_ = now_s + kIdlePollS;
    if (!view_ || client_.state() != link::SessionState::kOnline) {
        return;
    }
    if (!client_.clock().ready()) {
        // Without acks there is no clock: an empty input packet starts the exchange.
        if (now_s >= next_probe_s_) {
            next_probe_s_ = now_s + kProbeS;
            body_.clear();
            client_.send_input(body_, now_s);
        }
        return;
    }
    evaluate();
    send_inputs();
    housekeeping();
    const double server_s = client_.clock().server_time(now_s);
    const double next_tick_s = static_cast<double>(view_->tick() + 1) * world_->tick_s;
    const double next_input_s =
        (static_cast<double>(next_input_) - input_position()) * world_->tick_s;
    next_wake_s_ =
        now_s + std::clamp(std::min(next_tick_s - server_s, next_input_s), 0.0, kIdlePollS);
}

void Bot::evaluate() {
    if (!view_ || !client_.clock().ready()) {
        return;
    }
    const clock::TickClock ticks(1.0 / world_->tick_s);
    const Tick present = ticks.tick_at(client_.clock().server_time(now_s_));
    if (static_cast<double>(view_->tick() - present) * world_->tick_s > kSetBackS) {
        set_back(present);
    }
    view_->evaluate(present);
    if (settled_tick_ < 0 && joined_ && now_s_ - settling_since_s_ > kSettleS) {
        settled_tick_ = view_->tick();
    }
}

/// A server that stood still drops the ticks that it can't catch up with (TickSchedule). Its
/// clients predicted them all the same, and would show a standing world until it comes to them.
void Bot::set_back(Tick tick) {
    ++set_backs_;
    view_->set_back(tick);
    arrivals_.set_back(client_.clock().server_time(now_s_));
    next_input_ = -1;
    settling_since_s_ = now_s_;
    settled_tick_ = -1;
    observer_.on_set_back(*this);
}

/// In ticks: the command for the tick that this has reached is due.
double Bot::input_position() const {
    return (client_.clock().server_time(now_s_) + lead_->lead_s()) / world_->tick_s;
}

void Bot::send_inputs() {
    if (!lead_) {
        lead_.emplace(world_->tick_s);
        lead_->begin(client_.clock().rtt_s(), now_s_);
    }
    lead_->set_loss(client_.uplink().loss);
    lead_->advance(now_s_);
    const auto target = static_cast<Tick>(std::floor(input_position() + kSameTick));
    if (next_input_ < 0 || target - next_input_ > clock::InputLead::kMostTicks) {
        next_input_ = target;  // the beginning, or a stall of this process: the past is over
    }
    if (next_input_ > target) {
        return;
    }
    for (; next_input_ <= target; ++next_input_) {
        motion::InputCommand command;
        command.tick = next_input_;
        bool changed = false;
        if (joined_ && !quiet_ && view_->own().known()) {
            command = script_runner_.decide(*view_, next_input_, *this, changed);
        }
        view_->own().push(command);
        if (changed) {
            observer_.on_changed_course(*this, next_input_);
        }
    }
    body_.clear();
    const auto newest = view_->own().newest_commands(kCommandsPerPacket);
    wire::write_commands(newest, body_);
    commands_.on_sent(client_.send_input(body_, now_s_), view_->own().newest_tick(), newest.size());
}

void Bot::hear_of_commands(const wire::OwnState& own) {
    if (!lead_) {
        return;
    }
    if (notified_tick_ >= 0 && own.input_tick > notified_tick_) {
        // The server reports only some ticks, but always the first missed one. Between two missed
        // ticks, all were missed.
        const auto ticks = static_cast<std::uint64_t>(own.input_tick - notified_tick_);
        inputs_.ticks += ticks;
        inputs_.missing += own.input_missing ? (notified_missing_ ? ticks : 1) : 0;
        lead_->on_feedback(own.input_missing, client_.clock().rtt_s());
    }
    if (notified_tick_ >= 0 || !own.input_missing) {
        notified_tick_ = std::max(notified_tick_, own.input_tick);
        notified_missing_ = own.input_missing;
    }
}

void Bot::on_path_answers() {
    const link::UplinkUpdate& update = client_.uplink();
    std::size_t late = 0;
    if (commands_.on_update(update, late) && lead_) {
        lead_->add_path(update.server_receive_s - client_.clock().server_time(update.sent_s),
                        static_cast<int>(late));
    }
}

void Bot::housekeeping() {
    if (const std::string wish = view_->take_reset_wish(now_s_); !wish.empty()) {
        client_.reset_view(wish);
    }
    if (now_s_ < next_maintenance_s_) {
        return;
    }
    next_maintenance_s_ = now_s_ + 0.25;
    view_->maintain(now_s_);
    // Bit 2 of the rights: may receive the truth.
    if (settings_.audit_every_s > 0.0 && (client_.rights() & 2U) != 0 && joined_ &&
        now_s_ - last_audit_s_ >= settings_.audit_every_s) {
        last_audit_s_ = now_s_;
        client_.request_audit();
    }
}

void Bot::on_welcome(const wire::WelcomeMessage& welcome) {
    if (welcome.resumed) {
        return;
    }
    joined_ = false;
    ledger_.clear();
    settled_tick_ = -1;
    next_input_ = -1;
    lead_.reset();
    commands_.clear();
    notified_tick_ = -1;
    std::string error = "no world description";
    auto world =
        welcome.world ? worlds_.get(welcome.config_digest, *welcome.world, error) : nullptr;
    if (!world) {
        ++bad_worlds_;
        view_.reset();
        return;
    }
    world_ = std::move(world);
    arrivals_ = {};
    arrivals_.set_tick_s(world_->tick_s);
    const bool audited = settings_.audit_every_s > 0.0 && (welcome.rights & 2U) != 0;
    view_ = std::make_unique<view::View>(world_,
                                         view::ViewSettings{settings_.convergence,
                                                            audited,
                                                            settings_.view,
                                                            settings_.displayed_state,
                                                            settings_.meter},
                                         this);
    // Audit requests of many bots are spread over the interval.
    last_audit_s_ = now_s_ + settings_.audit_every_s *
                                 static_cast<double>(core::mix(settings_.index) % 1024) / 1024.0;
}

void Bot::on_joined(const wire::JoinedMessage& joined) {
    avatar_ = EntityId(joined.avatar);
    if (!joined_) {
        joined_ = true;
        joined_s_ = now_s_;
        settling_since_s_ = now_s_;
        joined_tick_ = joined.tick;
    }
    observer_.on_joined(*this, joined);
}

void Bot::on_event(const wire::EventMessage& event) {
    if (view_) {
        view_->apply(event);
    }
    if (std::string answer; ledger_.apply(event, avatar_, answer)) {
        client_.send_command(sandbox::COMMAND_AGREE, std::move(answer));
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
            client_.send_command(sandbox::COMMAND_ACCEPT, event.payload);
        }
    }
}

void Bot::on_audit(const wire::AuditRecordMessage& record) {
    last_audit_s_ = std::max(last_audit_s_, now_s_);
    observer_.on_audit(*this, record);
}

bool Bot::on_packet(const link::OpenedPacket& packet) {
    if (!view_) {
        return false;
    }
    packet_sent_s_ = packet.server_send_s;
    on_path_answers();
    const view::PacketResult taken = view_->apply(packet, now_s_);
    // An unreadable packet counts as not arrived.
    if (taken.read && client_.clock().ready()) {
        // On the view's own clock, which stands still when the estimate of the server's is set
        // back a little: the number of ticks shown without this update counts.
        const double shown_s = static_cast<double>(view_->tick()) * world_->tick_s;
        arrivals_.on_packet(packet.sequence,
                            packet.head.tick,
                            std::max(client_.clock().server_time(now_s_), shown_s),
                            packet.head.widened);
    }
    if (taken.correction.applied) {
        hear_of_commands(packet.head.own);
    }
    if (taken.correction.compared) {
        observer_.on_correction(*this, taken.correction.tick, taken.correction.distance_m);
    }
    return taken.read;
}

void Bot::on_shown(EntityId entity, Tick publication_tick, Tick from_tick) {
    observer_.on_shown(*this, entity, publication_tick, from_tick);
}

void Bot::command(std::uint32_t kind, std::string payload) {
    client_.send_command(kind, std::move(payload));
}

}  // namespace zoned::bot
