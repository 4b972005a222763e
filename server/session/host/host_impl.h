// SessionHost::Impl: the inside of SessionHost; its functions are grouped by file: login, frames,
// datagrams, outbox.
#pragma once

#include "server/mailbox/network_key.h"
#include "server/session/host/session_host.h"
#include "server/session/host/session_table.h"
#include "server/session/login/login.h"
#include "server/session/login/nonce_set.h"
#include "server/session/overload_control.h"
#include "server/session/reject.h"
#include "shared/core/rng.h"

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace zoned::session {

/// A stream that finished its handshake and that the host has not closed.
struct ClientStream {
    bool loopback = false;
    bool websocket = false;  ///< its datagrams are not sealed, and have no other way
    bool logged_in = false;
    mailbox::Address peer;
    std::optional<Identity> storing = {};  ///< of a login that waits until it is stored
};

struct SessionHost::Impl {
    Impl(HostSettings settings_in, SessionOutput output_in);

    // ---- host_login.cpp
    void on_hello(StreamId stream, const proto::Hello& hello, double now_s);
    void log_in(StreamId stream, const proto::Hello& hello, double now_s);
    /// The server's reasons against a client that is who it says; refuses it.
    bool turn_away(StreamId stream, const Identity& identity, double now_s);
    [[nodiscard]] std::size_t count_from(const mailbox::NetworkKey& network) const;
    void store_login(StreamId stream, Identity identity, double now_s);
    /// A character is in the world once.
    void end_others(const Identity& identity);
    /// Ends sessions of an account that would have more than it may.
    void make_room_for(const Identity& identity);
    /// Those with a ticket, ascending.
    [[nodiscard]] std::vector<Session*> sessions_of(const std::string& account) const;
    void let_in(StreamId stream,
                Identity identity,
                const std::optional<std::array<double, 3>>& place,
                double now_s);
    void resume(StreamId stream, const proto::Hello& hello, double now_s);
    /// The answer to Hello on the session's newest stream.
    void welcome(Session& session, const ClientStream& stream, bool resumed);
    void refuse(StreamId stream, const Refusal& refusal, const proto::Redirect* redirect = nullptr);
    void refuse_world(StreamId stream, const std::string& wanted);

    // ---- host_frames.cpp
    void on_frame(StreamId stream, std::span<const std::uint8_t> frame, double now_s);
    void on_message(Session& session, const proto::ClientMessage& message, double now_s);
    void on_command(Session& session, const proto::Command& command, double now_s);
    void on_confirm(Session& session, std::uint64_t event);
    void on_view_reset(Session& session, double now_s);
    void on_freeze(Session& session, bool on);
    void on_audit_request(Session& session, double now_s);
    void on_quit(Session& session);

    // ---- host_datagrams.cpp
    /// `from` is null where `carrier`'s stream brought it.
    void on_datagram(const mailbox::Address* from,
                     const Session* carrier,
                     std::span<const std::uint8_t> datagram,
                     double now_s,
                     double arrived_s);
    void send_acks(const Session& session, const DatagramPath::AckUpdate& acks);
    void follow_address(Session& session, const mailbox::Address* from, std::size_t bytes);
    void on_body(Session& session, std::span<const std::uint8_t> body);

    // ---- host_outbox.cpp
    void on_state(const mailbox::StatePacket& packet, double now_s, double server_time_s);
    void send_state(Session& session,
                    std::uint64_t sequence,
                    std::span<const std::uint8_t> body,
                    double now_s,
                    double server_time_s);
    void release(double now_s, double server_time_s);
    void release_of(Session& session, double until_s, double now_s, double server_time_s);
    void on_event(const mailbox::EventOut& event);
    void on_joined(const mailbox::Joined& joined);
    void on_kick(const mailbox::Kick& kick);
    void on_audit(const mailbox::AuditRecord& record);
    void on_commands_kept(const mailbox::CommandsKept& kept);
    bool queue_event(Session& session, const mailbox::EventOut& event, const EventBody& body);

    // ---- session_host.cpp: streams and sessions come and go
    void add_stream(StreamId stream, ClientStream opened, double connected_s);
    void send(StreamId stream, Bytes frame);
    void send_long(StreamId stream, Bytes head, const SharedBytes& tail);
    void note(SessionNote::Kind kind, const Session& session, const std::string& text) const;
    [[nodiscard]] double backlog_look_s() const;
    /// A client that takes what waits for it is alive, although it says nothing yet: a large world
    /// comes in over a slow line.
    void look_at_backlog(Session& session, double now_s) const;
    /// Closes a stream with a reason; a session on it is left without a stream.
    void close_stream(StreamId stream,
                      proto::ClosingReason reason,
                      const std::string& text,
                      const proto::Redirect* redirect = nullptr);
    /// Closes the stream of a session for a fault of the client, and begins the grace time.
    void suspend(Session& session,
                 proto::ClosingReason reason,
                 const std::string& text,
                 double now_s);
    /// Ends a session: closing message, Leave, gone.
    void end(Session& session,
             proto::ClosingReason reason,
             const std::string& text,
             mailbox::LeaveReason leave,
             const proto::Redirect* redirect = nullptr);
    void tick(double now_s, Tick tick_now);
    /// Whether states for it have anywhere to go.
    [[nodiscard]] static bool reachable(const Session& session, double now_s);
    /// The zones make no packets for a session that has nowhere to send them.
    void look_at_reach(Session& session, double now_s);
    /// Moves all deadlines by a time in which this host did not run.
    void excuse_stall(double stall_s);
    void shutdown(const std::string& text);

    [[nodiscard]] std::int64_t unix_time(double now_s) const;
    [[nodiscard]] Bytes take_buffer();
    void recycle(Bytes buffer);

    void reject(Reject reason) { rejects.count(reason); }

    HostSettings settings;
    SessionOutput output;
    SharedBytes world;  ///< field of each Welcome
    HostStats stats;
    RejectCounters rejects;
    SessionTable table;
    NonceSet nonces;
    BanList bans;
    OverloadControl overload;
    std::uint64_t measured_bytes = 0;  ///< of states, when the load was measured last
    double measured_s = -1.0;
    std::string draining;  ///< why logins are refused; empty: they are not
    std::unordered_map<StreamId, ClientStream> streams;
    /// In the order in which the streams opened, which is the order of their deadlines.
    std::deque<std::pair<double, StreamId>> login_deadlines;
    /// When a packet of Session::paced is due: a heap, the earliest in front.
    std::vector<std::pair<double, ClientId>> releases;
    core::Rng fault_rng;
    std::uint64_t datagram_turn = 0;  ///< 0: datagrams come one by one
    double gathered_s = 0.0;          ///< of that turn
    Tick current_tick = 0;
    double ticked_s = -1.0;  ///< when tick() last ran; below 0: never
    double unix_offset_s = 0.0;
    std::uint16_t udp_port = 0;
    bool shutting_down = false;

    // Buffers that are used again and again.
    std::vector<std::uint8_t> plain;
    std::vector<motion::InputCommand> commands;
    std::vector<Bytes> spare_buffers;
    proto::ClientMessage message_in;
};

}  // namespace zoned::session
