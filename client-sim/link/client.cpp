#include "client-sim/link/client.h"

#include "shared/core/utf8.h"

#include <algorithm>
#include <utility>

namespace zoned::link {

namespace {

/// Events are acknowledged in batches: at the latest after this time.
constexpr double kEventAckDelayS = 0.1;
/// Acknowledgements reach back 33 packets: so many packets are acknowledged in between at the
/// latest.
constexpr int kMostUnreported = 16;
/// While the path is asked, one datagram in this many goes inside the stream.
constexpr std::uint64_t kAskEvery = 8;
/// While tunnelling, one datagram in this many is tried over UDP, to return to UDP.
constexpr std::uint64_t kProbeEvery = 30;

/// Text from a server goes to a terminal; `otherwise` stands where it says nothing.
std::string shown(const std::string& text, std::string_view otherwise) {
    if (text.empty()) {
        return std::string(otherwise);
    }
    return core::is_clean_utf8(text) ? text : "(a text that cannot be shown)";
}

double backoff_s(int attempts) {
    return std::min(2.0, 0.1 * static_cast<double>(1 << std::min(attempts, 5)));
}

/// Whether a redirect names an address.
bool makes_sense(const wire::RedirectMessage& redirect) {
    return redirect.host.size() <= 253 && core::is_clean_utf8(redirect.host) &&
           redirect.tcp_port != 0 && redirect.tcp_port <= 65535;
}

}  // namespace

Client::Client(Transport& transport, SessionHandler& handler, Login login)
    : transport_(transport),
      handler_(handler),
      login_(std::move(login)) {
    listen();
}

Client::~Client() {
    transport_.set_events({});
}

void Client::listen() {
    TransportEvents events;
    events.opened = [this](bool inside) {
        Incoming in;
        in.kind = Incoming::IncomingKind::kOpened;
        in.inside = inside;
        incoming_.push_back(std::move(in));
    };
    events.frame = [this](Bytes frame) {
        Incoming in;
        in.kind = Incoming::IncomingKind::kFrame;
        in.bytes = std::move(frame);
        incoming_.push_back(std::move(in));
    };
    events.datagram = [this](Bytes datagram) {
        Incoming in;
        in.kind = Incoming::IncomingKind::kDatagram;
        in.bytes = std::move(datagram);
        incoming_.push_back(std::move(in));
    };
    events.closed = [this](std::string reason) {
        Incoming in;
        in.kind = Incoming::IncomingKind::kClosed;
        in.reason = std::move(reason);
        incoming_.push_back(std::move(in));
    };
    transport_.set_events(std::move(events));
}

void Client::start(double now_s) {
    connect(now_s);
}

void Client::connect(double now_s) {
    state_ = SessionState::kConnecting;
    attempt_s_ = now_s;
    ++attempts_;
    transport_.open();
}

void Client::quit(double now_s) {
    if (state_ == SessionState::kOnline) {
        advance(now_s);
    }
    if (state_ == SessionState::kOnline) {
        send({wire::EventAckMessage{events_.newest()}});
        send({wire::QuitMessage{}});
    }
    if (state_ != SessionState::kIdle && state_ != SessionState::kClosed) {
        transport_.close();
    }
    state_ = SessionState::kClosed;
}

void Client::advance(double now_s) {
    if (!incoming_.empty()) {
        handling_.swap(incoming_);
        for (Incoming& incoming : handling_) {
            handle(incoming, now_s);
        }
        handling_.clear();
    }
    timers(now_s);
}

void Client::handle(Incoming& incoming, double now_s) {
    if (state_ == SessionState::kClosed) {
        return;
    }
    switch (incoming.kind) {
        case Incoming::IncomingKind::kOpened:
            on_opened(incoming);
            break;
        case Incoming::IncomingKind::kFrame:
            on_frame(incoming.bytes, now_s);
            break;
        case Incoming::IncomingKind::kDatagram:
            on_datagram(incoming.bytes, false, now_s);
            break;
        case Incoming::IncomingKind::kClosed:
            on_closed(incoming.reason, now_s);
            break;
    }
}

void Client::on_opened(const Incoming& incoming) {
    if (state_ != SessionState::kConnecting) {
        return;
    }
    stats_.websocket = incoming.inside;
    wire::HelloMessage hello;
    hello.protocol_version = kProtocolVersion;
    hello.config_digest = login_.config_digest;
    hello.ticket = login_.ticket;
    hello.name = login_.name;
    hello.team = login_.team;
    hello.resume_token = resume_token_;
    hello.last_event = resume_token_.empty() ? 0 : events_.newest();
    hello.world = login_.world;
    send({std::move(hello)});
}

void Client::on_frame(const Bytes& frame, double now_s) {
    ++stats_.frames_in;
    stats_.frame_bytes_in += frame.size() + 4;
    wire::ServerMessage message;
    if (!wire::decode_message(frame, message)) {
        on_malformed();
        return;
    }
    if (std::holds_alternative<wire::AuditRecordMessage>(message.message)) {
        stats_.audit_bytes_in += frame.size() + 4;
    }
    std::visit([&](const auto& held) { receive(held, now_s); }, message.message);
}

void Client::receive(std::monostate /*nothing*/, double /*now_s*/) {
    on_malformed();
}

/// One bad frame among good ones is passed over; a first answer that is none is another service.
void Client::on_malformed() {
    ++stats_.malformed_frames;
    if (state_ == SessionState::kConnecting) {
        give_up("the answer cannot be read: this is no server of protocol version " +
                std::to_string(kProtocolVersion));
    }
}

void Client::give_up(std::string trouble) {
    trouble_ = std::move(trouble);
    transport_.close();
    state_ = SessionState::kClosed;
}

void Client::receive(const wire::JoinedMessage& joined, double now_s) {
    if (travelling_since_s_ >= 0.0) {
        stats_.travel_gaps_s.push_back(now_s - travelling_since_s_);
        travelling_since_s_ = -1.0;
    }
    handler_.on_joined(joined);
}

void Client::receive(const wire::AuditRecordMessage& record, double /*now_s*/) {
    handler_.on_audit(record);
}

void Client::receive(const wire::ClosingMessage& closing, double now_s) {
    closing_text_ = shown(closing.text, wire::text_of(closing.reason));
    if (closing.redirect && closing.reason == wire::ClosingReason::kElsewhere) {
        // At once: the server closes the stream behind this message, and the character waits.
        travelling_since_s_ = last_packet_s_;
        if (follow(*closing.redirect, now_s)) {
            ++stats_.travels;
            stats_.travels_prepared += transport_.prepared() ? 1 : 0;
        }
    }
}

void Client::receive(const wire::RedirectMessage& ahead, double now_s) {
    const bool in_time = now_s - prepared_s_ >= kPrepareEveryS;
    if (state_ == SessionState::kOnline && in_time && makes_sense(ahead)) {
        prepared_s_ = now_s;
        transport_.prepare(
            ahead.host, static_cast<std::uint16_t>(ahead.tcp_port), ahead.certificate_sha256);
    }
}

bool Client::follow(const wire::RedirectMessage& redirect, double now_s) {
    if (++hops_ > kMostHops) {
        trouble_ = "sent from server to server " + std::to_string(kMostHops) +
                   " times: the cluster's servers do not agree on who has the world";
    } else if (!makes_sense(redirect)) {
        trouble_ = "sent to another server, whose address makes no sense";
    } else {
        transport_.close();
        if (transport_.redirect(redirect.host,
                                static_cast<std::uint16_t>(redirect.tcp_port),
                                redirect.certificate_sha256)) {
            if (!redirect.ticket.empty()) {
                login_.ticket = redirect.ticket;
            }
            login_.world = redirect.world;
            login_.config_digest.clear();  // another world has another config
            resume_token_.clear();
            closing_text_.clear();
            attempts_ = 0;
            redirected_s_ = now_s;
            state_ = SessionState::kWaiting;
            attempt_s_ = now_s;
            return true;
        }
        trouble_ = "sent to another server, which this connection cannot go to";
    }
    transport_.close();
    state_ = SessionState::kClosed;
    return false;
}

void Client::receive(const wire::DatagramMessage& datagram, double now_s) {
    on_datagram(wire::bytes_of(datagram.sealed), true, now_s);
}

void Client::receive(const wire::CommandAckMessage& ack, double /*now_s*/) {
    drop_acknowledged(ack.through);
}

void Client::drop_acknowledged(std::uint64_t through) {
    while (!unacked_.empty() && unacked_.front().number <= through) {
        unacked_.pop_front();
    }
}

bool Client::take_keys(const wire::WelcomeMessage& welcome) {
    if (stats_.websocket) {
        channel_.unseal();
        return true;
    }
    const auto down = wire::SealKey::from(welcome.datagram_key_down);
    const auto up = wire::SealKey::from(welcome.datagram_key_up);
    if (!down || !up) {
        give_up("the server's welcome has no keys for datagrams");
    } else if (!channel_.rekey(*down, *up)) {
        give_up("the cryptography library does not offer AES-128-GCM");
    }
    return state_ == SessionState::kConnecting;
}

void Client::receive(const wire::WelcomeMessage& welcome, double now_s) {
    if (state_ != SessionState::kConnecting) {
        ++stats_.malformed_frames;
        return;
    }
    if (!take_keys(welcome)) {
        return;
    }
    state_ = SessionState::kOnline;
    trouble_.clear();
    attempts_ = 0;
    const bool moved = redirected_s_ >= 0.0;
    hops_ = 0;
    redirected_s_ = -1.0;
    rights_ = welcome.rights;
    world_name_ = welcome.world_name;
    resume_token_ = welcome.resume_token;
    grace_s_ = static_cast<double>(welcome.grace_s);
    last_udp_s_ = now_s;
    last_packet_s_ = now_s;
    path_ = stats_.websocket ? UplinkPath::kInside : UplinkPath::kUdp;
    stats_.tunnelled = stats_.tunnelled || stats_.websocket;
    channel_.set_connection(welcome.connection_id);
    if (welcome.world && welcome.world->tick_rate_hz > 0.0) {
        channel_.set_tick_s(1.0 / welcome.world->tick_rate_hz);
    }
    transport_.set_udp(static_cast<std::uint16_t>(welcome.udp_port), welcome.connection_id);
    if (welcome.resumed) {
        ++stats_.resumed;
        if (welcome.recovered) {
            ++stats_.recovered;
            channel_.recover();
        }
        drop_acknowledged(welcome.last_command);
        for (const PendingCommand& command : unacked_) {
            ++stats_.commands_resent;
            send_pending(command);
        }
    } else if (ever_online_) {
        forget_session();
        if (moved) {
            channel_.move();
        }
    }
    ever_online_ = true;
    handler_.on_welcome(welcome);
}

void Client::receive(const wire::RefusedMessage& refused, double now_s) {
    trouble_ = "refused: " + shown(refused.text, wire::text_of(refused.reason));
    if (refused.redirect && refused.reason == wire::RefusedReason::kElsewhere) {
        if (follow(*refused.redirect, now_s)) {
            ++stats_.redirects;
        }
        return;
    }
    transport_.close();
    if (refused.reason == wire::RefusedReason::kShuttingDown && redirected_s_ >= 0.0 &&
        now_s - redirected_s_ < kRedirectPatienceS) {
        state_ = SessionState::kWaiting;
        attempt_s_ = now_s + backoff_s(attempts_);
        return;
    }
    if (refused.reason == wire::RefusedReason::kResume && !resume_token_.empty()) {
        ++stats_.sessions_lost;
        resume_token_.clear();
        state_ = SessionState::kWaiting;
        attempt_s_ = now_s;
        return;
    }
    state_ = SessionState::kClosed;
}

void Client::forget_session() {
    channel_.restart();
    events_.restart();
    acked_events_ = 0;
    next_command_ = 1;
    unacked_.clear();
}

void Client::receive(const wire::EventMessage& event, double now_s) {
    event_ack_due_s_ = event_ack_due_s_ > 0.0 ? event_ack_due_s_ : now_s + kEventAckDelayS;
    const bool fresh = events_.accept(event.number, event.event_id);
    if (event.confirm) {
        // Confirmed again when it came again: the first confirmation may have died with a stream.
        send({wire::ConfirmMessage{event.event_id}});
    }
    if (fresh) {
        handler_.on_event(event);
    }
}

void Client::on_datagram(std::span<const std::uint8_t> datagram, bool tunnel, double now_s) {
    const auto packet = channel_.open(datagram, now_s);
    if (!packet) {
        return;
    }
    last_packet_s_ = now_s;
    if (!tunnel && path_ != UplinkPath::kInside) {
        last_udp_s_ = now_s;
        path_ = UplinkPath::kUdp;
    } else if (path_ == UplinkPath::kAsking && answered_s_ < 0.0) {
        answered_s_ = now_s;
    }
    if (handler_.on_packet(*packet)) {
        channel_.acknowledge(*packet, now_s);
    }
    // After a stall many packets are read at once, more than the next input could acknowledge.
    if (channel_.unreported() >= kMostUnreported) {
        send_input({}, now_s);
    }
}

void Client::on_closed(const std::string& reason, double now_s) {
    if (state_ == SessionState::kClosed || state_ == SessionState::kWaiting) {
        return;
    }
    const bool was_online = state_ == SessionState::kOnline;
    if (!closing_text_.empty()) {
        trouble_ = "closed by the server: " + closing_text_;
        state_ = SessionState::kClosed;
        return;
    }
    if (was_online) {
        ++stats_.streams_lost;
        lost_s_ = now_s;
    }
    trouble_ = reason.empty() ? "the server closed the stream" : reason;
    const bool may_resume = !resume_token_.empty() && now_s - lost_s_ < grace_s_;
    const bool on_its_way = redirected_s_ >= 0.0 && now_s - redirected_s_ < kRedirectPatienceS;
    if (!may_resume && !on_its_way && attempts_ >= kFirstAttempts) {
        state_ = SessionState::kClosed;
        return;
    }
    state_ = SessionState::kWaiting;
    attempt_s_ = now_s + backoff_s(attempts_);
}

void Client::timers(double now_s) {
    if (state_ == SessionState::kWaiting && now_s >= attempt_s_) {
        connect(now_s);
        return;
    }
    if (state_ == SessionState::kConnecting && now_s - attempt_s_ > kStreamTimeoutS) {
        transport_.close();
        on_closed("no answer from the server within 10 s", now_s);
        return;
    }
    if (state_ != SessionState::kOnline) {
        return;
    }
    if (event_ack_due_s_ > 0.0 && now_s >= event_ack_due_s_) {
        event_ack_due_s_ = 0.0;
        if (events_.newest() > acked_events_) {
            acked_events_ = events_.newest();
            send({wire::EventAckMessage{acked_events_}});
        }
    }
    choose_path(now_s);
}

void Client::choose_path(double now_s) {
    if (path_ == UplinkPath::kUdp && now_s - last_udp_s_ > kTunnelAfterS) {
        path_ = UplinkPath::kAsking;
        answered_s_ = -1.0;
        path_counter_ = 0;
    }
    if (path_ == UplinkPath::kAsking && answered_s_ >= 0.0 && now_s - answered_s_ > kTunnelSureS) {
        path_ = UplinkPath::kStream;
        stats_.tunnelled = true;
    }
}

bool Client::next_goes_inside_stream() {
    switch (path_) {
        case UplinkPath::kUdp:
            return false;
        case UplinkPath::kAsking:
            return path_counter_++ % kAskEvery == 0;
        case UplinkPath::kInside:
            return true;
        case UplinkPath::kStream:
            return ++path_counter_ % kProbeEvery != 0;
    }
    return false;
}

void Client::send(const wire::ClientMessage& message) {
    Bytes frame;
    wire::encode_message(message, frame);
    ++stats_.frames_out;
    stats_.frame_bytes_out += frame.size() + 4;
    transport_.send_frame(std::move(frame));
}

void Client::send_pending(const PendingCommand& command) {
    send({wire::CommandMessage{command.number, command.kind, command.payload}});
}

bool Client::send_command(std::uint32_t kind, std::string payload) {
    if (!ever_online_ || state_ == SessionState::kClosed ||
        unacked_.size() >= kMaxUnackedCommands) {
        return false;
    }
    unacked_.push_back({next_command_++, kind, std::move(payload)});
    ++stats_.commands_sent;
    if (state_ == SessionState::kOnline) {
        send_pending(unacked_.back());
    }
    return true;
}

std::uint64_t Client::send_input(std::span<const std::uint8_t> body, double now_s) {
    if (state_ != SessionState::kOnline || !channel_.has_keys()) {
        return 0;
    }
    Bytes datagram = channel_.seal(body, now_s);
    if (next_goes_inside_stream()) {
        send({wire::DatagramMessage{{datagram.begin(), datagram.end()}}});
        return channel_.newest_up();
    }
    transport_.send_datagram(std::move(datagram));
    return channel_.newest_up();
}

void Client::request_audit() {
    if (state_ == SessionState::kOnline) {
        send({wire::AuditRequestMessage{}});
    }
}

void Client::request_freeze(bool on) {
    if (state_ == SessionState::kOnline) {
        send({wire::FreezeRequestMessage{on}});
    }
}

void Client::reset_view(const std::string& reason) {
    if (state_ == SessionState::kOnline) {
        send({wire::ViewResetMessage{reason}});
    }
}

}  // namespace zoned::link
