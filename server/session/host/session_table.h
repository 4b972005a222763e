// SessionTable: all sessions, found by client, connection id, stream or resume token.
#pragma once

#include "server/session/datagrams/address_proof.h"
#include "server/session/datagrams/datagram_path.h"
#include "server/session/datagrams/pacer.h"
#include "server/session/event_queue.h"
#include "server/session/host/session_host.h"
#include "server/session/input_gate.h"
#include "server/session/login/login.h"
#include "server/session/login/secrets.h"
#include "shared/core/containers/id_table.h"
#include "shared/core/token_bucket.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <unordered_map>
#include <vector>

namespace zoned::session {

using ResumeToken = std::array<std::uint8_t, 16>;
using TokenDigest = std::array<std::uint8_t, 32>;  ///< SHA-256 of a token

/// The transport of state packets to a client.
enum class Route : std::uint8_t {
    kStream,   ///< inside frames: no datagram has come by UDP yet, or the newest came by the stream
    kAddress,  ///< UDP to the address of the newest datagram
};

/// A state packet that waits for its turn within the tick.
struct PacedState {
    double due_s = 0.0;
    std::uint64_t sequence = 0;
    Bytes body;
};

/// A logged-in client, with or without a live stream.
struct Session {
    explicit Session(const HostSettings& settings)
        : path(random_key(), random_key(), settings.rate),
          commands(settings.max_commands_per_s, 2.0 * settings.max_commands_per_s),
          datagrams(settings.max_datagrams_per_s, settings.max_datagrams_per_s),
          frames(settings.max_frames_per_s, 2.0 * settings.max_frames_per_s),
          view_resets(2.0, 6.0),
          audits(10.0, 20.0) {}

    ClientId client;
    std::uint32_t connection = 0;
    TokenDigest token_digest{};
    ResumeToken token{};     ///< zeros until the client of a recovered session has come back
    bool recovered = false;  ///< it outlived its process, and its client has not come back since
    Identity identity;
    StreamId stream;  ///< none during the grace time
    double grace_ends_s = 0.0;
    double last_heard_s = 0.0;        ///< datagram or frame
    std::uint64_t datagram_turn = 0;  ///< in which datagrams of it were read last ...
    int datagrams_in_turn = 0;        ///< ... and how many
    double last_datagram_s = 0.0;     ///< datagram, in either direction
    bool reached = true;              ///< as the zones were last notified (mailbox::Reach)
    double backlog_seen_s = 0.0;      ///< when its stream's backlog was looked at
    std::size_t backlog_bytes = 0;
    DatagramPath path;
    Pacer pacer;
    std::vector<PacedState> paced;  ///< ascending by due_s and sequence
    Route route = Route::kStream;
    /// The way that the client changed to, and on which no state went since: the next one does,
    /// even if datagrams come on the other way meanwhile. So a single probe is answered.
    std::optional<Route> unanswered;
    mailbox::Address address;
    bool has_address = false;     ///< a datagram came by UDP once
    AddressProof address_proof;   ///< of `address`
    bool inside_stream = false;   ///< a WebSocket: datagrams are not sealed, none may come by UDP
    mailbox::Address peer;        ///< of its newest stream
    std::uint64_t bytes_in = 0;   ///< datagrams that authenticated
    std::uint64_t bytes_out = 0;  ///< datagrams
    EventQueue events;
    std::set<std::uint64_t> unconfirmed;  ///< events that asked for a confirmation
    std::uint64_t last_command = 0;
    std::uint64_t kept_command = 0;  ///< up to here a crash loses none; may be acknowledged
    bool command_ack_due = false;
    bool travelling = false;                ///< its avatar has left; another world will have it
    bool progress_due = false;              ///< the journal does not know yet how far it has come
    std::optional<mailbox::Joined> joined;  ///< sent again when the client comes back
    InputGate gate;
    core::TokenBucket commands;
    core::TokenBucket datagrams;
    core::TokenBucket frames;
    core::TokenBucket view_resets;
    core::TokenBucket audits;

    [[nodiscard]] bool may(mailbox::Right right) const { return (identity.rights & right) != 0; }
};

/// Owns the sessions. Client ids count 1, 2, 3, ...; connection ids and tokens are random.
class SessionTable {
  public:
    /// A new session with its ids. `stream` must be new to the table.
    Session& create(const HostSettings& settings, StreamId stream);
    /// A session of a process that died, under its old number. No stream, no token.
    Session& restore(const HostSettings& settings, ClientId client, const TokenDigest& digest);

    /// New sessions get higher numbers than this.
    void number_after(ClientId client) { last_client_ = std::max(last_client_, client.value); }

    void remove(Session& session);

    /// Moves a session to another stream; none: it has lost its stream.
    void attach(Session& session, StreamId stream);

    [[nodiscard]] Session* by_client(ClientId client) const {
        return find_in(by_client_, client.value);
    }

    [[nodiscard]] Session* by_connection(std::uint32_t connection) const {
        return find_in(by_connection_, connection);
    }

    [[nodiscard]] Session* by_stream(StreamId stream) const;
    [[nodiscard]] Session* by_token(std::span<const std::uint8_t> token) const;

    /// Ascending by client id.
    [[nodiscard]] const std::vector<std::unique_ptr<Session>>& all() const { return sessions_; }

  private:
    void add(std::unique_ptr<Session> owned);

    std::vector<std::unique_ptr<Session>> sessions_;
    using ByNumber = core::IdTable<Session*>;

    static Session* find_in(const ByNumber& table, std::uint32_t number) {
        Session* const* session = table.find(number);
        return session == nullptr ? nullptr : *session;
    }

    ByNumber by_client_;
    ByNumber by_connection_;
    std::unordered_map<StreamId, Session*> by_stream_;
    std::unordered_map<std::uint64_t, Session*> by_token_;  ///< key: the beginning of the digest
    std::uint32_t last_client_ = 0;
};

}  // namespace zoned::session
