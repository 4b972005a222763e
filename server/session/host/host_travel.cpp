// Characters leave for another world of the cluster: the avatar first, then the session.
#include "server/session/host/host_impl.h"
#include "server/session/host/server_messages.h"

namespace zoned::session {

void SessionHost::trust_cluster(const PublicKey& key) {
    impl_->settings.cluster_keys.assign(1, key);
}

std::optional<Traveller> SessionHost::traveller(ClientId client) const {
    const Session* session = impl_->table.by_client(client);
    if (session == nullptr || session->travelling) {
        return std::nullopt;
    }
    const Identity& identity = session->identity;
    return Traveller{identity.nonce ? identity.account : std::string(),
                     identity.name,
                     identity.team,
                     identity.rights};
}

std::optional<Traveller> SessionHost::waiting_login(StreamId stream) const {
    const auto it = impl_->streams.find(stream);
    if (it == impl_->streams.end() || !it->second.storing) {
        return std::nullopt;
    }
    const Identity& identity = *it->second.storing;
    return Traveller{identity.account, identity.name, identity.team, identity.rights};
}

bool SessionHost::begin_travel(ClientId client, bool keep_avatar) {
    Session* session = impl_->table.by_client(client);
    if (session == nullptr || session->travelling) {
        return false;
    }
    if (!keep_avatar) {
        impl_->output.to_zones(mailbox::Leave{client, mailbox::LeaveReason::kQuit});
    }
    session->travelling = true;
    return true;
}

void SessionHost::redirect(ClientId client,
                           const std::string& text,
                           const proto::Redirect& redirect) {
    if (Session* session = impl_->table.by_client(client)) {
        impl_->end(
            *session, proto::CLOSING_ELSEWHERE, text, mailbox::LeaveReason::kQuit, &redirect);
    }
}

void SessionHost::announce(ClientId client, const proto::Redirect& redirect) {
    const Session* session = impl_->table.by_client(client);
    if (session != nullptr && session->stream && !session->travelling) {
        impl_->send(session->stream, ahead_frame(redirect));
    }
}

std::size_t SessionHost::end_account(const std::string& account,
                                     ClientId but,
                                     const std::string& text) {
    std::vector<Session*> chosen;
    for (const auto& session : impl_->table.all()) {
        if (session->identity.nonce && session->identity.account == account &&
            session->client != but) {
            chosen.push_back(session.get());
        }
    }
    for (Session* session : chosen) {
        impl_->end(*session, proto::CLOSING_KICKED, text, mailbox::LeaveReason::kKicked);
    }
    return chosen.size();
}

}  // namespace zoned::session
