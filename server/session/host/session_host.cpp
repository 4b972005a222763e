#include "server/session/host/session_host.h"

#include "server/session/host/host_impl.h"
#include "server/session/host/server_messages.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace zoned::session {

namespace {

constexpr std::size_t kSpareBuffers = 256;

/// tick() comes ten times a second; a gap longer than this is a stall of this process.
constexpr double kStall_s = 0.5;

HostSettings checked(HostSettings settings) {
    if (settings.input_window_ticks < 1 || settings.input_window_ticks > kMaxInputWindowTicks) {
        throw std::invalid_argument("the input window must be 1 to " +
                                    std::to_string(kMaxInputWindowTicks) + " ticks, not " +
                                    std::to_string(settings.input_window_ticks));
    }
    if (!(settings.max_load > 0.0)) {
        throw std::invalid_argument("the most load must be above 0");
    }
    if (settings.max_commands_per_s == 0 || settings.max_datagrams_per_s == 0 ||
        settings.max_frames_per_s == 0) {
        throw std::invalid_argument(
            "the limits of commands, datagrams and frames per second must "
            "be at least 1");
    }
    return settings;
}

const char* leave_text(mailbox::LeaveReason reason) {
    switch (reason) {
        case mailbox::LeaveReason::kQuit:
            return "quit";
        case mailbox::LeaveReason::kTimeout:
            return "did not come back within its grace time";
        case mailbox::LeaveReason::kKicked:
            return "kicked";
        case mailbox::LeaveReason::kShutdown:
            break;
    }
    return "the server closes";
}

/// Which message a frame begins with: its key is number << 3 | wire type, in groups of 7 bits
/// (Protocol Buffers, "Encoding").
std::uint32_t message_number(std::span<const std::uint8_t> frame) {
    std::uint32_t key = 0;
    for (std::size_t i = 0; i < std::min<std::size_t>(frame.size(), 5); ++i) {
        key |= static_cast<std::uint32_t>(frame[i] & 0x7FU) << (7 * i);
        if ((frame[i] & 0x80U) == 0) {
            break;
        }
    }
    return key >> 3U;
}

}  // namespace

// ---------------------------------------------------------------- streams and sessions

SessionHost::Impl::Impl(HostSettings settings_in, SessionOutput output_in)
    : settings(checked(std::move(settings_in))),
      output(std::move(output_in)),
      world(std::make_shared<const Bytes>(world_field(settings.world))),
      nonces(settings.max_remembered_tickets),
      fault_rng(settings.testing.seed) {
    plain.reserve(wire::kMaxDatagramBytes);
    commands.reserve(wire::kMaxCommandsPerPacket);
}

void SessionHost::Impl::send(StreamId stream, Bytes frame) {
    ++stats.frames_out;
    stats.frame_bytes_out += frame.size();
    stats.frame_bytes_by_message[message_number(frame)] += frame.size();
    output.send_frame(stream, std::move(frame));
}

void SessionHost::Impl::send_long(StreamId stream, Bytes head, const SharedBytes& tail) {
    if (!output.send_long_frame) {
        head.insert(head.end(), tail->begin(), tail->end());
        send(stream, std::move(head));
        return;
    }
    ++stats.frames_out;
    stats.frame_bytes_out += head.size() + tail->size();
    stats.frame_bytes_by_message[message_number(head)] += head.size() + tail->size();
    output.send_long_frame(stream, std::move(head), tail);
}

void SessionHost::Impl::note(SessionNote::Kind kind,
                             const Session& session,
                             const std::string& text) const {
    if (output.note) {
        output.note({kind,
                     session.client,
                     session.identity.account,
                     session.identity.name,
                     session.peer,
                     session.identity.rights,
                     text});
    }
}

/// Two looks show whether a client takes its bytes: both must fit into the time of silence.
double SessionHost::Impl::backlog_look_s() const {
    return std::min(1.0, 0.25 * settings.silence_timeout_s);
}

void SessionHost::Impl::look_at_backlog(Session& session, double now_s) const {
    if (!output.stream_backlog || now_s - session.backlog_seen_s < backlog_look_s()) {
        return;
    }
    const std::size_t backlog = output.stream_backlog(session.stream);
    if (backlog < session.backlog_bytes) {
        session.last_heard_s = now_s;
    }
    session.backlog_bytes = backlog;
    session.backlog_seen_s = now_s;
}

void SessionHost::Impl::add_stream(StreamId stream, ClientStream opened, double connected_s) {
    streams[stream] = std::move(opened);
    const std::pair<double, StreamId> deadline{connected_s + settings.login_timeout_s, stream};
    login_deadlines.insert(
        std::upper_bound(login_deadlines.begin(), login_deadlines.end(), deadline), deadline);
}

void SessionHost::Impl::close_stream(StreamId stream,
                                     proto::ClosingReason reason,
                                     const std::string& text,
                                     const proto::Redirect* redirect) {
    if (Session* session = table.by_stream(stream)) {
        table.attach(*session, StreamId{});
    }
    if (streams.erase(stream) != 0) {
        send(stream, closing_frame(reason, text, redirect));
        output.close_stream(stream);
    }
}

void SessionHost::Impl::suspend(Session& session,
                                proto::ClosingReason reason,
                                const std::string& text,
                                double now_s) {
    session.grace_ends_s = now_s + settings.grace_s;
    note(SessionNote::Kind::kAway, session, text);
    close_stream(session.stream, reason, text);
}

void SessionHost::Impl::end(Session& session,
                            proto::ClosingReason reason,
                            const std::string& text,
                            mailbox::LeaveReason leave,
                            const proto::Redirect* redirect) {
    if (session.stream) {
        close_stream(session.stream, reason, text, redirect);
    }
    note(SessionNote::Kind::kLeft, session, text.empty() ? leave_text(leave) : text);
    if (!session.travelling) {
        output.to_zones(mailbox::Leave{session.client, leave});
    }
    table.remove(session);
    stats.sessions = static_cast<std::uint32_t>(table.all().size());
}

/// The silence of a stalled server is not the silence of its clients: what they sent meanwhile may
/// still wait in the sockets.
void SessionHost::Impl::excuse_stall(double stall_s) {
    for (auto& deadline : login_deadlines) {
        deadline.first += stall_s;
    }
    for (const auto& session : table.all()) {
        session->last_heard_s += stall_s;
        session->last_datagram_s += stall_s;
        session->grace_ends_s += stall_s;
        session->path.excuse_stall(stall_s);
    }
}

void SessionHost::Impl::tick(double now_s, Tick tick_now) {
    current_tick = tick_now;
    if (ticked_s >= 0.0 && now_s - ticked_s > kStall_s) {
        excuse_stall(now_s - ticked_s);
    }
    ticked_s = now_s;
    nonces.prune(unix_time(now_s));
    while (!login_deadlines.empty() && login_deadlines.front().first <= now_s) {
        const StreamId stream = login_deadlines.front().second;
        login_deadlines.pop_front();
        const auto it = streams.find(stream);
        if (it != streams.end() && !it->second.logged_in) {
            reject(Reject::kLoginTimeout);
            close_stream(stream, proto::CLOSING_TIMEOUT, "no Hello came within the login time");
        }
    }
    std::vector<Session*> expired;
    for (const auto& session : table.all()) {
        look_at_reach(*session, now_s);
        if (!session->stream) {
            if (now_s >= session->grace_ends_s) {
                expired.push_back(session.get());
            }
            continue;
        }
        if (session->command_ack_due) {
            session->command_ack_due = false;
            send(session->stream,
                 command_ack_frame(settings.journaled ? session->kept_command
                                                      : session->last_command));
        }
        if (session->progress_due && settings.journaled) {
            session->progress_due = false;
            output.to_zones(mailbox::SessionProgress{
                session->client, session->last_command, session->events.acknowledged()});
        }
        if (const auto acks = session->path.take_silence(now_s)) {
            send_acks(*session, *acks);
        }
        if (now_s - session->last_heard_s > backlog_look_s()) {
            look_at_backlog(*session, now_s);
        }
        if (now_s - session->last_heard_s > settings.silence_timeout_s) {
            reject(Reject::kSilence);
            suspend(*session, proto::CLOSING_TIMEOUT, "nothing was heard for too long", now_s);
        }
    }
    for (Session* session : expired) {
        end(*session, proto::CLOSING_TIMEOUT, "", mailbox::LeaveReason::kTimeout);
    }
}

void SessionHost::Impl::shutdown(const std::string& text) {
    shutting_down = true;
    while (!table.all().empty()) {
        end(*table.all().front(), proto::CLOSING_SHUTDOWN, text, mailbox::LeaveReason::kShutdown);
    }
    std::vector<StreamId> open;
    for (const auto& [stream, state] : streams) {
        open.push_back(stream);
    }
    std::sort(open.begin(), open.end());
    for (const StreamId stream : open) {
        close_stream(stream, proto::CLOSING_SHUTDOWN, text);
    }
}

std::int64_t SessionHost::Impl::unix_time(double now_s) const {
    return static_cast<std::int64_t>(std::floor(now_s + unix_offset_s));
}

Bytes SessionHost::Impl::take_buffer() {
    Bytes buffer;
    if (spare_buffers.empty()) {
        buffer.reserve(wire::kMaxDatagramBytes);
    } else {
        buffer = std::move(spare_buffers.back());
        spare_buffers.pop_back();
    }
    return buffer;
}

void SessionHost::Impl::recycle(Bytes buffer) {
    if (spare_buffers.size() < kSpareBuffers) {
        spare_buffers.push_back(std::move(buffer));
    }
}

// ---------------------------------------------------------------- the public face

SessionHost::SessionHost(HostSettings settings, SessionOutput output)
    : impl_(std::make_unique<Impl>(std::move(settings), std::move(output))) {
}

SessionHost::~SessionHost() = default;

void SessionHost::on_stream_open(StreamId stream, bool loopback, double connected_s) {
    impl_->add_stream(stream, ClientStream{loopback, false, false, {}}, connected_s);
}

void SessionHost::on_websocket_open(StreamId stream, bool local, double connected_s) {
    impl_->add_stream(stream, ClientStream{local, true, false, {}}, connected_s);
}

void SessionHost::on_frame(StreamId stream, std::span<const std::uint8_t> frame, double now_s) {
    impl_->on_frame(stream, frame, now_s);
}

void SessionHost::on_stream_closed(StreamId stream, double now_s) {
    impl_->streams.erase(stream);
    if (Session* session = impl_->table.by_stream(stream)) {
        impl_->table.attach(*session, StreamId{});
        session->grace_ends_s = now_s + impl_->settings.grace_s;
        impl_->note(SessionNote::Kind::kAway, *session, "its connection ended");
    }
}

void SessionHost::begin_datagrams(double gathered_s) {
    ++impl_->datagram_turn;
    impl_->gathered_s = gathered_s;
}

void SessionHost::on_datagram(const mailbox::Address& from,
                              std::span<const std::uint8_t> datagram,
                              double now_s,
                              double arrived_s) {
    ++impl_->stats.packets_in;
    impl_->stats.bytes_in += datagram.size();
    impl_->on_datagram(&from, nullptr, datagram, now_s, arrived_s);
}

void SessionHost::on_outbox(const mailbox::OutboxItem& item, double now_s, double server_time_s) {
    if (const auto* state = std::get_if<mailbox::StatePacket>(&item)) {
        impl_->on_state(*state, now_s, server_time_s);
    } else if (const auto* event = std::get_if<mailbox::EventOut>(&item)) {
        impl_->on_event(*event);
    } else if (const auto* joined = std::get_if<mailbox::Joined>(&item)) {
        impl_->on_joined(*joined);
    } else if (const auto* kick = std::get_if<mailbox::Kick>(&item)) {
        impl_->on_kick(*kick);
    } else if (const auto* audit = std::get_if<mailbox::AuditRecord>(&item)) {
        impl_->on_audit(*audit);
    } else if (const auto* kept = std::get_if<mailbox::CommandsKept>(&item)) {
        impl_->on_commands_kept(*kept);
    }
}

void SessionHost::release(double now_s, double server_time_s) {
    impl_->release(now_s, server_time_s);
}

double SessionHost::next_release_s() const {
    return impl_->releases.empty() ? std::numeric_limits<double>::infinity()
                                   : impl_->releases.front().first;
}

void SessionHost::tick(double now_s, Tick current_tick) {
    impl_->tick(now_s, current_tick);
}

void SessionHost::set_unix_time(double unix_s, double now_s) {
    impl_->unix_offset_s = unix_s - now_s;
}

void SessionHost::recycle(Bytes datagram) {
    impl_->recycle(std::move(datagram));
}

void SessionHost::shutdown(const std::string& text) {
    impl_->shutdown(text);
}

void SessionHost::set_udp_port(std::uint16_t port) {
    impl_->udp_port = port;
}

const HostStats& SessionHost::stats() const {
    impl_->stats.rejected = impl_->rejects.by_name();
    return impl_->stats;
}

std::vector<ClientId> SessionHost::sessions() const {
    std::vector<ClientId> out;
    out.reserve(impl_->table.all().size());
    for (const auto& session : impl_->table.all()) {
        out.push_back(session->client);
    }
    return out;
}

RttPercentiles SessionHost::rtt_percentiles() const {
    std::vector<std::uint32_t> rtts_us;
    for (const auto& session : impl_->table.all()) {
        if (session->path.rtt_us() != 0) {
            rtts_us.push_back(session->path.rtt_us());
        }
    }
    RttPercentiles out;
    out.sessions = rtts_us.size();
    if (!rtts_us.empty()) {
        std::sort(rtts_us.begin(), rtts_us.end());
        // Nearest rank: the smallest value that at least this share does not exceed.
        const auto rank = [&](double share) {
            const auto n = static_cast<double>(rtts_us.size());
            const auto index = static_cast<std::size_t>(std::ceil(share * n)) - 1;
            return rtts_us[std::min(index, rtts_us.size() - 1)] * 1e-3;
        };
        out.p50_ms = rank(0.50);
        out.p99_ms = rank(0.99);
    }
    return out;
}

}  // namespace zoned::session
