#include "server/session/host/host_impl.h"
#include "server/session/host/server_messages.h"

#include <algorithm>
#include <cmath>

namespace zoned::session {

namespace {

std::span<const std::uint8_t> as_bytes(const std::string& s) {
    return {reinterpret_cast<const std::uint8_t*>(s.data()), s.size()};
}

}  // namespace

void SessionHost::Impl::on_hello(StreamId stream, const proto::Hello& hello, double now_s) {
    if (shutting_down) {
        refuse(stream,
               {proto::REFUSED_SHUTTING_DOWN,
                Reject::kLoginShutdown,
                "the server is shutting down: try again later"});
    } else if (const auto refusal = check_versions(settings, hello)) {
        refuse(stream, *refusal);
    } else if (!hello.resume_token().empty()) {
        resume(stream, hello, now_s);
    } else {
        log_in(stream, hello, now_s);
    }
}

void SessionHost::Impl::log_in(StreamId stream, const proto::Hello& hello, double now_s) {
    ClientStream& state = streams.at(stream);
    auto identity = check_identity(settings, hello, state.loopback, unix_time(now_s), nonces);
    if (!identity) {
        refuse(stream, identity.error());
        return;
    }
    if (const AccountBan* ban = bans.find(identity->account, unix_time(now_s))) {
        refuse(stream,
               {proto::REFUSED_BANNED,
                Reject::kLoginBanned,
                "the account is banned" + (ban->reason.empty() ? "" : ": " + ban->reason)});
        return;
    }
    if (!draining.empty()) {
        refuse(stream, {proto::REFUSED_SHUTTING_DOWN, Reject::kLoginShutdown, draining});
        return;
    }
    if (table.all().size() >= settings.max_sessions) {
        refuse(stream,
               {proto::REFUSED_FULL,
                Reject::kLoginFull,
                "the server is full: all of its " + std::to_string(settings.max_sessions) +
                    " places are taken"});
        return;
    }
    Session& session = table.create(settings, state.down, state.up, stream);
    session.identity = std::move(*identity);
    session.last_heard_s = now_s;
    session.peer = state.peer;
    if (session.identity.nonce) {
        nonces.insert(*session.identity.nonce, session.identity.expires_s);
    }
    state.logged_in = true;
    stats.sessions = static_cast<std::uint32_t>(table.all().size());
    stats.sessions_max = std::max(stats.sessions_max, stats.sessions);
    send_welcome(session, false);
    note(SessionNote::Kind::kJoined, session, "");
    output.to_zones(mailbox::Join{
        session.client, session.identity.name, session.identity.team, session.identity.rights});
}

void SessionHost::Impl::resume(StreamId stream, const proto::Hello& hello, double now_s) {
    Session* session = table.by_token(as_bytes(hello.resume_token()));
    if (session == nullptr) {
        refuse(stream,
               {proto::REFUSED_RESUME,
                Reject::kLoginResume,
                "the session is unknown, or its grace time of " +
                    std::to_string(std::lround(settings.grace_s)) + " s has passed: log in anew"});
        return;
    }
    if (!session->events.can_continue_after(hello.last_event())) {
        refuse(stream,
               {proto::REFUSED_RESUME,
                Reject::kLoginResume,
                "the client's newest event is number " + std::to_string(hello.last_event()) +
                    "; the server cannot go on from there (its newest is " +
                    std::to_string(session->events.newest()) + "): log in anew"});
        return;
    }
    if (session->stream) {
        close_stream(
            session->stream, proto::CLOSING_REPLACED, "the session goes on on another connection");
    }
    ClientStream& state = streams.at(stream);
    state.logged_in = true;
    table.attach(*session, stream);
    session->path.rekey(state.down, state.up);
    session->last_heard_s = now_s;
    session->peer = state.peer;
    session->command_ack_due = false;  // Welcome says it
    ++stats.resumed;
    session->events.acknowledge(hello.last_event());
    send_welcome(*session, true);
    note(SessionNote::Kind::kResumed, *session, "");
    if (session->joined) {
        send(stream, joined_frame(*session->joined));
    }
    for (const EventQueue::QueuedEvent& entry : session->events.waiting()) {
        send(stream, event_frame(entry.number, entry.body));
    }
}

void SessionHost::Impl::send_welcome(const Session& session, bool resumed) {
    proto::Welcome welcome;
    welcome.set_client_id(session.client.value);
    welcome.set_connection_id(session.connection);
    welcome.set_udp_port(udp_port);
    welcome.set_resume_token(session.token.data(), session.token.size());
    welcome.set_grace_s(static_cast<std::uint32_t>(std::lround(settings.grace_s)));
    welcome.set_resumed(resumed);
    welcome.set_last_command(session.last_command);
    welcome.set_config_digest(settings.config_digest);
    welcome.set_rights(session.identity.rights);
    if (resumed) {
        send(session.stream, welcome_head(welcome, 0));
    } else {
        send_long(session.stream, welcome_head(welcome, world->size()), world);
    }
}

void SessionHost::Impl::refuse(StreamId stream, const Refusal& refusal) {
    reject(refusal.counter);
    proto::ServerMessage message;
    proto::Refused& refused = *message.mutable_refused();
    refused.set_reason(refusal.reason);
    refused.set_text(refusal.text);
    refused.set_protocol_version(settings.protocol_version);
    refused.set_config_digest(settings.config_digest);
    if (const auto it = streams.find(stream); output.note && it != streams.end()) {
        SessionNote refusal_note;
        refusal_note.kind = SessionNote::Kind::kRefused;
        refusal_note.from = it->second.peer;
        refusal_note.text = refusal.text;
        output.note(refusal_note);
    }
    streams.erase(stream);
    send(stream, serialise(message));
    output.close_stream(stream);
}

}  // namespace zoned::session
