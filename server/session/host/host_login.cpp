#include "server/session/host/host_impl.h"
#include "server/session/host/server_messages.h"
#include "server/session/login/secrets.h"
#include "shared/core/assert.h"
#include "shared/core/utf8.h"

#include <algorithm>
#include <cmath>

namespace zoned::session {

namespace {

std::span<const std::uint8_t> as_bytes(const std::string& s) {
    return {reinterpret_cast<const std::uint8_t*>(s.data()), s.size()};
}

mailbox::SessionBegun begun_of(const Session& session) {
    return {session.client,
            {session.token_digest.begin(), session.token_digest.end()},
            session.identity.account,
            session.identity.name,
            session.identity.team,
            session.identity.rights,
            session.identity.nonce.has_value()};
}

}  // namespace

void SessionHost::Impl::on_hello(StreamId stream, const proto::Hello& hello, double now_s) {
    if (shutting_down) {
        refuse(stream,
               {proto::REFUSED_SHUTTING_DOWN,
                Reject::kLoginShutdown,
                "the server is shutting down: try again later"});
    } else if (const auto older = check_protocol(settings, hello)) {
        refuse(stream, *older);
    } else if (!hello.world().empty() && hello.world() != settings.world_name) {
        refuse_world(stream, hello.world());
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
    if (turn_away(stream, *identity, now_s)) {
        return;
    }
    if (identity->nonce && output.store_login) {
        store_login(stream, std::move(*identity), now_s);
    } else {
        let_in(stream, std::move(*identity), std::nullopt, now_s);
    }
}

void SessionHost::Impl::store_login(StreamId stream, Identity identity, double now_s) {
    end_others(identity);
    // At once: the same ticket must not come again while the first is being stored.
    nonces.insert(*identity.nonce, identity.expires_s);
    LoginToStore login;
    login.stream = stream;
    login.account = identity.account;
    login.character = identity.name;
    login.nonce = *identity.nonce;
    login.expires_s = identity.expires_s;
    login.unix_s = unix_time(now_s);
    streams.at(stream).storing = std::move(identity);
    output.store_login(login);
}

void SessionHost::Impl::end_others(const Identity& identity) {
    std::vector<Session*> same = sessions_of(identity.account);
    std::erase_if(same, [&](const Session* s) { return s->identity.name != identity.name; });
    for (Session* session : same) {
        end(*session,
            proto::CLOSING_REPLACED,
            "the character logged in elsewhere",
            mailbox::LeaveReason::kKicked);
    }
}

void SessionHost::Impl::make_room_for(const Identity& identity) {
    const std::size_t most = settings.max_per_account;
    if (most == 0 || !identity.nonce) {
        return;
    }
    std::vector<Session*> all = sessions_of(identity.account);
    // Another session of the same character comes first, then the oldest.
    std::stable_partition(all.begin(), all.end(), [&](const Session* s) {
        return s->identity.name == identity.name;
    });
    for (std::size_t i = 0; i + most <= all.size(); ++i) {
        end(*all[i],
            proto::CLOSING_REPLACED,
            "the account logged in elsewhere (session.max_per_account)",
            mailbox::LeaveReason::kKicked);
    }
}

std::vector<Session*> SessionHost::Impl::sessions_of(const std::string& account) const {
    std::vector<Session*> out;
    for (const auto& session : table.all()) {
        if (session->identity.nonce && session->identity.account == account) {
            out.push_back(session.get());
        }
    }
    return out;
}

std::size_t SessionHost::Impl::count_from(const mailbox::NetworkKey& network) const {
    return static_cast<std::size_t>(
        std::count_if(table.all().begin(), table.all().end(), [&](const auto& session) {
            return mailbox::network_of(session->peer) == network;
        }));
}

void SessionHost::on_login_stored(StreamId stream,
                                  bool stored,
                                  const std::optional<std::array<double, 3>>& place,
                                  double now_s) {
    const auto it = impl_->streams.find(stream);
    if (it == impl_->streams.end() || !it->second.storing) {
        return;  // the client did not wait
    }
    Identity identity = std::move(*it->second.storing);
    it->second.storing.reset();
    if (!stored) {
        impl_->refuse(stream,
                      {proto::REFUSED_SHUTTING_DOWN,
                       Reject::kLoginNotStored,
                       "the server cannot store logins at the moment: get a new ticket and try "
                       "again later"});
        return;
    }
    if (impl_->shutting_down) {
        impl_->refuse(stream,
                      {proto::REFUSED_SHUTTING_DOWN,
                       Reject::kLoginShutdown,
                       "the server is shutting down: try again later"});
    } else if (!impl_->turn_away(stream, identity, now_s)) {
        impl_->end_others(identity);
        impl_->let_in(stream, std::move(identity), place, now_s);
    }
}

void SessionHost::remember_ticket(const TicketNonce& nonce, std::int64_t expires_s) {
    impl_->nonces.insert(nonce, expires_s);
}

bool SessionHost::Impl::turn_away(StreamId stream, const Identity& identity, double now_s) {
    if (const AccountBan* ban = bans.find(identity.account, unix_time(now_s))) {
        refuse(stream,
               {proto::REFUSED_BANNED,
                Reject::kLoginBanned,
                "the account is banned" + (ban->reason.empty() ? "" : ": " + ban->reason)});
        return true;
    }
    if (!draining.empty()) {
        refuse(stream, {proto::REFUSED_SHUTTING_DOWN, Reject::kLoginShutdown, draining});
        return true;
    }
    const bool admitted = overload.admits(table.all().size(), settings.max_load);
    stats.refusing = overload.refusing();
    if (!admitted) {
        refuse(stream,
               {proto::REFUSED_FULL,
                Reject::kLoginBusy,
                "the server is busy: its " + std::to_string(table.all().size()) + " clients take " +
                    std::to_string(std::lround(100.0 * overload.load())) +
                    " % of the time there is, try again later (network.max_load)"});
        return true;
    }
    if (settings.max_per_address > 0 &&
        count_from(mailbox::network_of(streams.at(stream).peer)) >= settings.max_per_address) {
        refuse(stream,
               {proto::REFUSED_FULL,
                Reject::kLoginAddress,
                "all of the " + std::to_string(settings.max_per_address) +
                    " places for one address are taken (network.max_sessions_per_address)"});
        return true;
    }
    if (table.all().size() >= settings.max_sessions) {
        refuse(stream,
               {proto::REFUSED_FULL,
                Reject::kLoginFull,
                "the server is full: all of its " + std::to_string(settings.max_sessions) +
                    " places are taken"});
        return true;
    }
    return false;
}

void SessionHost::Impl::let_in(StreamId stream,
                               Identity identity,
                               const std::optional<std::array<double, 3>>& place,
                               double now_s) {
    make_room_for(identity);
    ClientStream& state = streams.at(stream);
    Session& session = table.create(settings, stream);
    session.identity = std::move(identity);
    session.last_heard_s = now_s;
    session.peer = state.peer;
    if (session.identity.nonce) {
        nonces.insert(*session.identity.nonce, session.identity.expires_s);
    }
    state.logged_in = true;
    stats.sessions = static_cast<std::uint32_t>(table.all().size());
    stats.sessions_max = std::max(stats.sessions_max, stats.sessions);
    welcome(session, state, false);
    note(SessionNote::Kind::kJoined, session, "");
    if (settings.journaled) {
        output.to_zones(begun_of(session));
    }
    mailbox::Join join;
    join.client = session.client;
    join.name = session.identity.name;
    join.team = session.identity.team;
    join.rights = session.identity.rights;
    // Development mode gives all clients one account, which is nobody's.
    if (session.identity.nonce) {
        join.account = session.identity.account;
    }
    if (place) {
        std::copy(place->begin(), place->end(), join.spawn);
        join.placed = true;
    }
    output.to_zones(std::move(join));
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
    if (session->travelling) {
        refuse(stream,
               {proto::REFUSED_RESUME,
                Reject::kLoginResume,
                "the character is on its way to another world: log in anew"});
        return;
    }
    if (session->stream) {
        close_stream(
            session->stream, proto::CLOSING_REPLACED, "the session goes on on another connection");
    }
    ClientStream& state = streams.at(stream);
    state.logged_in = true;
    table.attach(*session, stream);
    session->last_heard_s = now_s;
    session->peer = state.peer;
    look_at_reach(*session, now_s);
    session->command_ack_due = false;  // Welcome says it
    ++stats.resumed;
    session->events.acknowledge(hello.last_event());
    session->progress_due = true;
    // A session that outlived its process knew the digest alone.
    std::copy_n(hello.resume_token().begin(), session->token.size(), session->token.begin());
    welcome(*session, state, true);
    session->recovered = false;
    note(SessionNote::Kind::kResumed, *session, "");
    if (session->joined) {
        send(stream, joined_frame(*session->joined));
    }
    for (const EventQueue::QueuedEvent& entry : session->events.waiting()) {
        send(stream, event_frame(entry.number, entry.body));
    }
}

void SessionHost::restore(KeptSession kept, double now_s) {
    TokenDigest digest{};
    ZONED_ASSERT(kept.begun.token_digest.size() == digest.size(), "the digest of a token");
    std::copy(kept.begun.token_digest.begin(), kept.begun.token_digest.end(), digest.begin());
    Session& session = impl_->table.restore(impl_->settings, kept.begun.client, digest);
    session.identity.account = std::move(kept.begun.account);
    session.identity.name = std::move(kept.begun.name);
    session.identity.team = std::move(kept.begun.team);
    session.identity.rights = kept.begun.rights;
    if (kept.begun.ticketed) {
        session.identity.nonce.emplace();  // used up long ago; the store remembers which
    }
    session.last_heard_s = now_s;
    session.grace_ends_s = now_s + impl_->settings.grace_s;
    session.last_command = kept.commands;
    session.kept_command = kept.commands;
    session.events = std::move(kept.events);
    session.unconfirmed = std::move(kept.unconfirmed);
    session.joined = kept.joined;
    impl_->stats.sessions = static_cast<std::uint32_t>(impl_->table.all().size());
    impl_->stats.sessions_max = std::max(impl_->stats.sessions_max, impl_->stats.sessions);
}

void SessionHost::number_sessions_after(ClientId client) {
    impl_->table.number_after(client);
}

/// The newest stream of a session says how its datagrams travel: inside it, or sealed with keys
/// that nobody has had before.
void SessionHost::Impl::welcome(Session& session, const ClientStream& stream, bool resumed) {
    proto::Welcome welcome;
    session.inside_stream = stream.websocket;
    session.unanswered.reset();
    if (stream.websocket) {
        session.path.unseal();
        session.route = Route::kStream;
    } else {
        const wire::SealKey down = random_key();
        const wire::SealKey up = random_key();
        session.path.rekey(down, up);
        welcome.set_datagram_key_down(down.bytes());
        welcome.set_datagram_key_up(up.bytes());
    }
    welcome.set_client_id(session.client.value);
    welcome.set_connection_id(session.connection);
    welcome.set_udp_port(udp_port);
    welcome.set_resume_token(session.token.data(), session.token.size());
    welcome.set_recovered(session.recovered);
    welcome.set_grace_s(static_cast<std::uint32_t>(std::lround(settings.grace_s)));
    welcome.set_resumed(resumed);
    welcome.set_last_command(settings.journaled ? session.kept_command : session.last_command);
    welcome.set_config_digest(settings.config_digest);
    welcome.set_rights(session.identity.rights);
    welcome.set_world_name(settings.world_name);
    if (resumed) {
        send(session.stream, welcome_head(welcome, 0));
    } else {
        send_long(session.stream, welcome_head(welcome, world->size()), world);
    }
}

void SessionHost::Impl::refuse_world(StreamId stream, const std::string& wanted) {
    const std::optional<proto::Redirect> found =
        output.find_world ? output.find_world(wanted) : std::nullopt;
    const std::string name = core::is_clean_utf8(wanted) && wanted.size() <= 64 ? wanted : "?";
    std::string text = "this server has no world of the name " + name;
    if (found) {
        text = "another server has the world " + name + ": " + found->host() + " port " +
               std::to_string(found->tcp_port());
    } else if (!settings.world_name.empty()) {
        text = "no server of the cluster has the world " + name + " at the moment";
    }
    refuse(stream,
           {proto::REFUSED_ELSEWHERE, Reject::kLoginElsewhere, text},
           found ? &*found : nullptr);
}

void SessionHost::refuse_login(StreamId stream,
                               const std::string& text,
                               const proto::Redirect* redirect) {
    const auto it = impl_->streams.find(stream);
    if (it == impl_->streams.end() || !it->second.storing) {
        return;  // the client did not wait
    }
    // Nobody was let in by it: the client may come again with the same ticket.
    impl_->nonces.erase(*it->second.storing->nonce);
    it->second.storing.reset();
    if (redirect != nullptr) {
        impl_->refuse(stream, {proto::REFUSED_ELSEWHERE, Reject::kLoginElsewhere, text}, redirect);
    } else {
        impl_->refuse(stream, {proto::REFUSED_SHUTTING_DOWN, Reject::kLoginNotStored, text});
    }
}

void SessionHost::Impl::refuse(StreamId stream,
                               const Refusal& refusal,
                               const proto::Redirect* redirect) {
    reject(refusal.counter);
    proto::ServerMessage message;
    proto::Refused& refused = *message.mutable_refused();
    refused.set_reason(refusal.reason);
    refused.set_text(refusal.text);
    refused.set_protocol_version(settings.protocol_version);
    refused.set_config_digest(settings.config_digest);
    if (redirect != nullptr) {
        *refused.mutable_redirect() = *redirect;
    }
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
