#include "client-sim/link/client.h"

#include "shared/core/utf8.h"

#include <algorithm>
#include <utility>

namespace zoned::link {

namespace {

/// Events are acknowledged in batches: at the latest after this time.
constexpr double kEventAckDelayS = 0.1;
/// While the path is asked, one datagram in this many goes inside the stream.
constexpr std::uint64_t kAskEvery = 8;
/// While tunnelling, one datagram in this many is tried over UDP, to return to UDP.
constexpr std::uint64_t kProbeEvery = 30;
constexpr std::size_t kMaxUnackedCommands = 1024;

/// Text from a server goes to a terminal.
std::string shown(const std::string& text) {
    return core::is_clean_utf8(text) ? text : "(a text that cannot be shown)";
}

double backoff_s(int attempts) {
    return std::min(2.0, 0.1 * static_cast<double>(1 << std::min(attempts, 5)));
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
    events.opened = [this](const wire::SealKey& down, const wire::SealKey& up) {
        Incoming in;
        in.kind = Incoming::IncomingKind::kOpened;
        in.down = down;
        in.up = up;
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
        proto::ClientMessage message;
        message.mutable_event_ack()->set_through(events_.newest());
        send(message);
        message.mutable_quit();
        send(message);
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
    channel_.rekey(incoming.down, incoming.up);
    proto::ClientMessage message;
    proto::Hello& hello = *message.mutable_hello();
    hello.set_protocol_version(kProtocolVersion);
    hello.set_config_digest(login_.config_digest);
    hello.set_ticket(login_.ticket);
    hello.set_name(login_.name);
    hello.set_team(login_.team);
    hello.set_resume_token(resume_token_);
    hello.set_last_event(resume_token_.empty() ? 0 : events_.newest());
    send(message);
}

void Client::on_frame(const Bytes& frame, double now_s) {
    ++stats_.frames_in;
    stats_.frame_bytes_in += frame.size() + 4;
    proto::ServerMessage message;
    if (!message.ParseFromArray(frame.data(), static_cast<int>(frame.size()))) {
        ++stats_.malformed_frames;
        return;
    }
    switch (message.message_case()) {
        case proto::ServerMessage::kWelcome:
            on_welcome(message.welcome(), now_s);
            break;
        case proto::ServerMessage::kRefused:
            on_refused(message.refused(), now_s);
            break;
        case proto::ServerMessage::kEvent:
            on_event(message.event());
            event_ack_due_s_ = event_ack_due_s_ > 0.0 ? event_ack_due_s_ : now_s + kEventAckDelayS;
            break;
        case proto::ServerMessage::kJoined:
            handler_.on_joined(message.joined());
            break;
        case proto::ServerMessage::kAudit:
            stats_.audit_bytes_in += frame.size() + 4;
            handler_.on_audit(message.audit());
            break;
        case proto::ServerMessage::kClosing:
            closing_text_ = message.closing().text().empty()
                                ? proto::ClosingReason_Name(message.closing().reason())
                                : shown(message.closing().text());
            break;
        case proto::ServerMessage::kDatagram: {
            const std::string& sealed = message.datagram().sealed();
            on_datagram(
                {reinterpret_cast<const std::uint8_t*>(sealed.data()), sealed.size()}, true, now_s);
            break;
        }
        case proto::ServerMessage::kCommandAck:
            while (!unacked_.empty() &&
                   unacked_.front().number <= message.command_ack().through()) {
                unacked_.pop_front();
            }
            break;
        case proto::ServerMessage::MESSAGE_NOT_SET:
            ++stats_.malformed_frames;
            break;
    }
}

void Client::on_welcome(const proto::Welcome& welcome, double now_s) {
    if (state_ != SessionState::kConnecting) {
        ++stats_.malformed_frames;
        return;
    }
    state_ = SessionState::kOnline;
    trouble_.clear();
    attempts_ = 0;
    rights_ = welcome.rights();
    if (!welcome.recovered()) {
        resume_token_ = welcome.resume_token();
    }
    grace_s_ = static_cast<double>(welcome.grace_s());
    last_udp_s_ = now_s;
    last_packet_s_ = now_s;
    path_ = UplinkPath::kUdp;
    channel_.set_connection(welcome.connection_id());
    if (welcome.has_world() && welcome.world().tick_rate_hz() > 0.0) {
        channel_.set_tick_s(1.0 / welcome.world().tick_rate_hz());
    }
    transport_.set_udp(static_cast<std::uint16_t>(welcome.udp_port()), welcome.connection_id());
    if (welcome.resumed()) {
        ++stats_.resumed;
        if (welcome.recovered()) {
            ++stats_.recovered;
            channel_.recover();
        }
        while (!unacked_.empty() && unacked_.front().number <= welcome.last_command()) {
            unacked_.pop_front();
        }
        for (const PendingCommand& command : unacked_) {
            ++stats_.commands_resent;
            send_pending(command);
        }
    } else if (ever_online_) {
        forget_session();
    }
    ever_online_ = true;
    handler_.on_welcome(welcome);
}

void Client::on_refused(const proto::Refused& refused, double now_s) {
    trouble_ = "refused: " + (refused.text().empty() ? proto::RefusedReason_Name(refused.reason())
                                                     : shown(refused.text()));
    transport_.close();
    if (refused.reason() == proto::REFUSED_RESUME && !resume_token_.empty()) {
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

void Client::on_event(const proto::Event& event) {
    const bool fresh = events_.accept(event.number(), event.event_id());
    if (event.confirm()) {
        // Confirmed again when it came again: the first confirmation may have died with a stream.
        proto::ClientMessage message;
        message.mutable_confirm()->set_event_id(event.event_id());
        send(message);
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
    if (!tunnel) {
        last_udp_s_ = now_s;
        path_ = UplinkPath::kUdp;
    } else if (path_ == UplinkPath::kAsking && answered_s_ < 0.0) {
        answered_s_ = now_s;
    }
    if (handler_.on_packet(*packet)) {
        channel_.acknowledge(*packet, now_s);
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
    if (!may_resume && attempts_ >= kFirstAttempts) {
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
            proto::ClientMessage message;
            message.mutable_event_ack()->set_through(acked_events_);
            send(message);
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
        case UplinkPath::kStream:
            return ++path_counter_ % kProbeEvery != 0;
    }
    return false;
}

void Client::send(const proto::ClientMessage& message) {
    Bytes frame(message.ByteSizeLong());
    message.SerializeToArray(frame.data(), static_cast<int>(frame.size()));
    ++stats_.frames_out;
    stats_.frame_bytes_out += frame.size() + 4;
    transport_.send_frame(std::move(frame));
}

void Client::send_pending(const PendingCommand& command) {
    proto::ClientMessage message;
    message.mutable_command()->set_number(command.number);
    message.mutable_command()->set_kind(command.kind);
    message.mutable_command()->set_payload(command.payload);
    send(message);
}

void Client::send_command(std::uint32_t kind, std::string payload) {
    if (!ever_online_ || state_ == SessionState::kClosed ||
        unacked_.size() >= kMaxUnackedCommands) {
        return;
    }
    unacked_.push_back({next_command_++, kind, std::move(payload)});
    ++stats_.commands_sent;
    if (state_ == SessionState::kOnline) {
        send_pending(unacked_.back());
    }
}

std::uint64_t Client::send_input(std::span<const std::uint8_t> body, double now_s) {
    if (state_ != SessionState::kOnline || !channel_.has_keys()) {
        return 0;
    }
    Bytes datagram = channel_.seal(body, now_s);
    if (next_goes_inside_stream()) {
        proto::ClientMessage message;
        message.mutable_datagram()->set_sealed(datagram.data(), datagram.size());
        send(message);
        return channel_.newest_up();
    }
    transport_.send_datagram(std::move(datagram));
    return channel_.newest_up();
}

void Client::request_audit() {
    if (state_ == SessionState::kOnline) {
        proto::ClientMessage message;
        message.mutable_audit();
        send(message);
    }
}

void Client::request_freeze(bool on) {
    if (state_ == SessionState::kOnline) {
        proto::ClientMessage message;
        message.mutable_freeze()->set_on(on);
        send(message);
    }
}

void Client::reset_view(const std::string& reason) {
    if (state_ == SessionState::kOnline) {
        proto::ClientMessage message;
        message.mutable_view_reset()->set_reason(reason);
        send(message);
    }
}

}  // namespace zoned::link
