#include "server/session/host/host_impl.h"
#include "server/session/host/server_messages.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <utility>

namespace zoned::session {

namespace {

/// A datagram is longer than its body by this.
constexpr std::size_t kSealedBytes = wire::kMaxDatagramBytes - wire::kMaxDownBodyBytes;

/// Without a stream a client is still sent states while it is heard by UDP; this long after it was
/// last heard.
constexpr double kStatesAfterSilence_s = 1.0;

}  // namespace

void SessionHost::Impl::on_state(const mailbox::StatePacket& packet,
                                 double now_s,
                                 double server_time_s) {
    Session* session = table.by_client(packet.client);
    if (session == nullptr) {
        reject(Reject::kOutNoSession);  // it left while the packet was made
        return;
    }
    if (packet.body.size() > wire::kMaxDownBodyBytes) {
        reject(Reject::kOutOversize);
        return;
    }
    const double tick_s = 1.0 / settings.tick_rate_hz;
    const double due_s = session->pacer.due_s(
        now_s, static_cast<double>(packet.body.size()), session->path.rate().bytes_per_s(), tick_s);
    if (due_s <= now_s) {
        // Order matters: packets held of the ticks before go first.
        release_of(*session, std::numeric_limits<double>::infinity(), now_s, server_time_s);
        send_state(*session, packet.sequence, packet.body, now_s, server_time_s);
        return;
    }
    PacedState& paced = session->paced.emplace_back();
    paced.due_s = due_s;
    paced.sequence = packet.sequence;
    paced.body = take_buffer();
    paced.body.assign(packet.body.begin(), packet.body.end());
    releases.emplace_back(due_s, packet.client);
    std::push_heap(releases.begin(), releases.end(), std::greater<>());
}

/// The held packets of one session that are due until then.
void SessionHost::Impl::release_of(Session& session,
                                   double until_s,
                                   double now_s,
                                   double server_time_s) {
    const auto later = std::find_if(session.paced.begin(),
                                    session.paced.end(),
                                    [&](const PacedState& paced) { return paced.due_s > until_s; });
    for (auto paced = session.paced.begin(); paced != later; ++paced) {
        send_state(session, paced->sequence, paced->body, now_s, server_time_s);
        recycle(std::move(paced->body));
    }
    session.paced.erase(session.paced.begin(), later);
}

/// Times of packets that went before their time find nothing, and are dropped.
void SessionHost::Impl::release(double now_s, double server_time_s) {
    while (!releases.empty() && releases.front().first <= now_s) {
        const ClientId client = releases.front().second;
        std::pop_heap(releases.begin(), releases.end(), std::greater<>());
        releases.pop_back();
        if (Session* session = table.by_client(client)) {
            release_of(*session, now_s, now_s, server_time_s);
        } else {
            reject(Reject::kOutNoSession);
        }
    }
}

bool SessionHost::Impl::reachable(const Session& session, double now_s) {
    return session.stream || (session.route == Route::kAddress &&
                              now_s - session.last_datagram_s <= kStatesAfterSilence_s);
}

void SessionHost::Impl::look_at_reach(Session& session, double now_s) {
    if (const bool reached = reachable(session, now_s); reached != session.reached) {
        session.reached = reached;
        output.to_zones(mailbox::Reach{session.client, reached});
    }
}

void SessionHost::Impl::send_state(Session& session,
                                   std::uint64_t sequence,
                                   std::span<const std::uint8_t> body,
                                   double now_s,
                                   double server_time_s) {
    if (!session.path.may_send(sequence)) {
        reject(Reject::kOutSequence);
        return;
    }
    const Route way = session.stream ? session.unanswered.value_or(session.route) : session.route;
    const bool unproved =
        way == Route::kAddress && !session.address_proof.may_send(body.size() + kSealedBytes);
    if (unproved && !session.stream) {
        reject(Reject::kOutUnproved);
        return;
    }
    const bool tunnel = way == Route::kStream || unproved;
    if (!reachable(session, now_s)) {
        reject(Reject::kOutSuspended);
        return;
    }
    if (tunnel && output.stream_backlog &&
        output.stream_backlog(session.stream) > (session.inside_stream
                                                     ? settings.max_websocket_backlog_bytes
                                                     : settings.max_tunnel_backlog_bytes)) {
        // States grow stale in a queue; acks will show that this one is missing.
        reject(Reject::kOutTunnelBacklog);
        return;
    }
    Bytes datagram = take_buffer();
    session.path.seal(session.connection, sequence, body, now_s, server_time_s, plain, datagram);
    session.bytes_out += datagram.size();
    if (!unproved) {
        session.unanswered.reset();
    }
    if (tunnel) {
        ++stats.tunnelled;
        stats.tunnelled_bytes += datagram.size();
        send(session.stream, datagram_frame(datagram));
        recycle(std::move(datagram));
    } else {
        ++stats.packets_out;
        stats.bytes_out += datagram.size();
        session.address_proof.send(sequence, datagram.size());
        output.send_datagram(session.address, std::move(datagram));
    }
}

void SessionHost::Impl::on_event(const mailbox::EventOut& event) {
    const EventBody body = encode_event_body(event);
    const auto chance = [&](double probability) {
        return probability > 0.0 && fault_rng.unit() < static_cast<float>(probability);
    };
    for (const ClientId client : event.recipients) {
        Session* session = table.by_client(client);
        if (session == nullptr) {
            reject(Reject::kOutNoSession);
        } else if (chance(settings.testing.drop_event_probability)) {
            session->events.skip_number();
        } else if (queue_event(*session, event, body) &&
                   chance(settings.testing.double_event_probability)) {
            queue_event(*session, event, body);
        }
    }
}

bool SessionHost::Impl::queue_event(Session& session,
                                    const mailbox::EventOut& event,
                                    const EventBody& body) {
    if (session.events.waiting().size() >= settings.max_unacked_events ||
        session.unconfirmed.size() >= settings.max_unacked_events) {
        // An event may not be lost and may not wait for ever: the session ends.
        reject(Reject::kEventsOverflow);
        end(session,
            proto::CLOSING_PROTOCOL,
            "more than " + std::to_string(settings.max_unacked_events) +
                " events wait for the client's acknowledgement or confirmation",
            mailbox::LeaveReason::kTimeout);
        return false;
    }
    const std::uint64_t number = session.events.push(body);
    if (event.confirm) {
        session.unconfirmed.insert(event.event.value);
    }
    if (session.stream) {
        send(session.stream, event_frame(number, body));
    }
    return true;
}

void SessionHost::Impl::on_joined(const mailbox::Joined& joined) {
    Session* session = table.by_client(joined.client);
    if (session == nullptr) {
        reject(Reject::kOutNoSession);
        return;
    }
    session->joined = joined;
    if (session->stream) {
        send(session->stream, joined_frame(joined));
    }
}

void SessionHost::Impl::on_kick(const mailbox::Kick& kick) {
    Session* session = table.by_client(kick.client);
    if (session == nullptr) {
        reject(Reject::kOutNoSession);
        return;
    }
    end(*session, proto::CLOSING_KICKED, kick.reason, mailbox::LeaveReason::kKicked);
}

void SessionHost::Impl::on_commands_kept(const mailbox::CommandsKept& kept) {
    if (Session* session = table.by_client(kept.client)) {
        session->kept_command = std::max(session->kept_command, kept.through);
        session->command_ack_due = true;
    }
}

void SessionHost::Impl::on_audit(const mailbox::AuditRecord& record) {
    Session* session = table.by_client(record.client);
    if (session == nullptr) {
        reject(Reject::kOutNoSession);
    } else if (!session->may(mailbox::kRightAudit)) {
        // The truth never leaves the server without the right to it, whatever the zones say.
        reject(Reject::kOutAuditNoRight);
    } else if (!session->stream) {
        reject(Reject::kOutSuspended);
    } else {
        send(session->stream, audit_frame(record));
    }
}

}  // namespace zoned::session
