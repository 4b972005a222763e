#include "server/session/host/session_table.h"

#include "server/session/login/secrets.h"
#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::session {

namespace {

template <class Map, class Key>
Session* find_in(const Map& map, const Key& key) {
    const auto it = map.find(key);
    return it == map.end() ? nullptr : it->second;
}

}  // namespace

Session& SessionTable::create(const HostSettings& settings,
                              const wire::SealKey& down,
                              const wire::SealKey& up,
                              StreamId stream) {
    auto owned = std::make_unique<Session>(settings, down, up);
    Session& session = *owned;
    session.client = ClientId{++last_client_};
    do {
        session.connection = random_nonzero_u32();
    } while (by_connection_.count(session.connection) != 0);
    do {
        random_bytes(session.token);
    } while (by_token_.count(hash_prefix(session.token)) != 0);
    sessions_.push_back(std::move(owned));
    by_client_[session.client] = &session;
    by_connection_[session.connection] = &session;
    by_token_[hash_prefix(session.token)] = &session;
    attach(session, stream);
    return session;
}

void SessionTable::remove(Session& session) {
    attach(session, StreamId{});
    by_client_.erase(session.client);
    by_connection_.erase(session.connection);
    by_token_.erase(hash_prefix(session.token));
    const auto it = std::lower_bound(
        sessions_.begin(), sessions_.end(), session.client, [](const auto& s, ClientId client) {
            return s->client < client;
        });
    ZONED_ASSERT(it != sessions_.end() && it->get() == &session, "a session is not in its table");
    sessions_.erase(it);
}

void SessionTable::attach(Session& session, StreamId stream) {
    if (session.stream) {
        by_stream_.erase(session.stream);
    }
    session.stream = stream;
    if (stream) {
        ZONED_ASSERT(by_stream_.count(stream) == 0, "two sessions on one stream");
        by_stream_[stream] = &session;
    }
}

Session* SessionTable::by_client(ClientId client) const {
    return find_in(by_client_, client);
}

Session* SessionTable::by_connection(std::uint32_t connection) const {
    return find_in(by_connection_, connection);
}

Session* SessionTable::by_stream(StreamId stream) const {
    return find_in(by_stream_, stream);
}

Session* SessionTable::by_token(std::span<const std::uint8_t> token) const {
    Session* session = find_in(by_token_, hash_prefix(token));
    return session != nullptr && equal_in_constant_time(session->token, token) ? session : nullptr;
}

}  // namespace zoned::session
