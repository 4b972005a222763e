#include "server/session/host/session_table.h"

#include "server/session/login/secrets.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cstring>

namespace zoned::session {

namespace {

template <class Map, class Key>
Session* find_in_map(const Map& map, const Key& key) {
    const auto it = map.find(key);
    return it == map.end() ? nullptr : it->second;
}

std::uint64_t prefix_of(const TokenDigest& digest) {
    std::uint64_t prefix = 0;
    std::memcpy(&prefix, digest.data(), sizeof(prefix));
    return prefix;
}

}  // namespace

Session& SessionTable::create(const HostSettings& settings, StreamId stream) {
    auto owned = std::make_unique<Session>(settings);
    Session& session = *owned;
    session.client = ClientId{last_client_ + 1};
    do {
        session.connection = random_nonzero_u32();
    } while (by_connection(session.connection) != nullptr);
    do {
        random_bytes(session.token);
        session.token_digest = sha256(session.token);
    } while (by_token_.count(prefix_of(session.token_digest)) != 0);
    add(std::move(owned));
    attach(session, stream);
    return session;
}

Session& SessionTable::restore(const HostSettings& settings,
                               ClientId client,
                               const TokenDigest& digest) {
    // No datagram opens before the client comes back, and Welcome tells it the keys.
    auto owned = std::make_unique<Session>(settings);
    Session& session = *owned;
    session.client = client;
    session.token_digest = digest;
    session.recovered = true;
    do {
        session.connection = random_nonzero_u32();
    } while (by_connection(session.connection) != nullptr);
    add(std::move(owned));
    return session;
}

void SessionTable::add(std::unique_ptr<Session> owned) {
    Session& session = *owned;
    ZONED_ASSERT(sessions_.empty() || sessions_.back()->client < session.client,
                 "sessions come in the order of their numbers");
    number_after(session.client);
    sessions_.push_back(std::move(owned));
    by_client_.insert(session.client.value, &session);
    by_connection_.insert(session.connection, &session);
    by_token_[prefix_of(session.token_digest)] = &session;
}

void SessionTable::remove(Session& session) {
    attach(session, StreamId{});
    by_client_.erase(session.client.value);
    by_connection_.erase(session.connection);
    by_token_.erase(prefix_of(session.token_digest));
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

Session* SessionTable::by_stream(StreamId stream) const {
    return find_in_map(by_stream_, stream);
}

Session* SessionTable::by_token(std::span<const std::uint8_t> token) const {
    if (token.size() != ResumeToken().size()) {
        return nullptr;
    }
    const TokenDigest digest = sha256(token);
    Session* session = find_in_map(by_token_, prefix_of(digest));
    return session != nullptr && equal_in_constant_time(session->token_digest, digest) ? session
                                                                                       : nullptr;
}

}  // namespace zoned::session
