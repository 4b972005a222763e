// SessionHost: all sessions of a server; it takes and gives bytes without sockets, so that net and
// the test harness can both drive it.
#pragma once

#include "server/mailbox/address.h"
#include "server/mailbox/messages.h"
#include "server/session/event_queue.h"
#include "server/session/host/session_figures.h"
#include "server/session/login/ban_list.h"
#include "server/session/login/ticket.h"
#include "server/session/session_settings.h"
#include "shared/core/ids.h"
#include "shared/wire/seal.h"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace zoned::session {

using Bytes = std::vector<std::uint8_t>;
using SharedBytes = std::shared_ptr<const Bytes>;

/// An accepted TCP connection, numbered by its acceptor. Zero = none.
using StreamId = StrongId<struct StreamTag, std::uint64_t>;

/// A login by a ticket, to be kept before the client is let in.
struct LoginToStore {
    StreamId stream;
    std::string account;
    std::string character;  ///< the name in the game
    TicketNonce nonce{};
    std::int64_t expires_s = 0;  ///< of the ticket
    std::int64_t unix_s = 0;     ///< now
};

/// The host's output. The host calls these from within its own calls; they must not call back.
struct SessionOutput {
    std::function<void(StreamId, Bytes frame)>
        send_frame;  ///< serialised ServerMessage, without the length prefix
    std::function<void(StreamId)> close_stream;  ///< after all frames before it have been sent
    std::function<void(const mailbox::Address&, Bytes datagram)> send_datagram;
    std::function<void(mailbox::InboxItem)> to_zones;
    std::function<std::size_t(StreamId)>
        stream_backlog;  ///< bytes that wait in a stream; may be empty: never any
    /// A frame that ends with bytes which many frames share; may be empty: it is put together and
    /// goes by send_frame.
    std::function<void(StreamId, Bytes head, SharedBytes tail)> send_long_frame = {};
    std::function<void(const SessionNote&)> note = {};  ///< may be empty
    /// Keeps a login durably; SessionHost::on_login_stored says that it is. Empty: nothing is kept,
    /// clients are let in at once.
    std::function<void(const LoginToStore&)> store_login = {};
    /// The server of a cluster that has a world; none where nobody has it. May be empty.
    std::function<std::optional<proto::Redirect>(const std::string& world)> find_world = {};
};

/// A session whose character may go to another world.
struct Traveller {
    std::string account;  ///< empty: it came without a ticket
    std::string name;
    std::string team;
    std::uint32_t rights = 0;
};

/// The sessions that an operator means: those for which any of these holds that is set.
struct SessionChoice {
    ClientId client;
    std::string account;
    std::string name;
};

/// A session as a journal knows it, so that its client can come back to another process.
struct KeptSession {
    mailbox::SessionBegun begun;
    std::uint64_t commands = 0;  ///< numbers used up
    EventQueue events;           ///< those that the client may lack
    std::set<std::uint64_t> unconfirmed;
    std::optional<mailbox::Joined> joined;
};

/// Round trips over all sessions that have measured one.
struct RttPercentiles {
    double p50_ms = 0.0;
    double p99_ms = 0.0;
    std::size_t sessions = 0;
};

struct HostStats {
    std::uint64_t packets_in = 0;
    std::uint64_t packets_out = 0;
    std::uint64_t bytes_in = 0;  ///< datagrams, UDP payload
    std::uint64_t bytes_out = 0;
    std::uint64_t frames_in = 0;
    std::uint64_t frames_out = 0;
    std::uint64_t frame_bytes_in = 0;
    std::uint64_t frame_bytes_out = 0;
    /// Of frame_bytes_out, by the number of the field of proto::ServerMessage.
    std::map<std::uint32_t, std::uint64_t> frame_bytes_by_message;
    std::uint32_t sessions = 0;
    std::uint32_t sessions_max = 0;
    std::uint64_t tunnelled = 0;        ///< state packets that took the stream; not in packets_out
    std::uint64_t tunnelled_bytes = 0;  ///< of them, sealed; not in bytes_out
    std::uint64_t address_changes = 0;
    double load = 0.0;      ///< of the last second, as OverloadControl takes it
    bool refusing = false;  ///< logins, because of the load
    /// Bytes per second that a client may cost because of the load; infinity: as ever.
    double ceiling_bytes_per_s = std::numeric_limits<double>::infinity();
    std::uint64_t resumed = 0;
    std::map<std::string, std::uint64_t>
        rejected;  ///< reason -> count: nothing from outside is dropped without a count
};

/// A session is a login; it outlives its streams. Where a stream ends without Quit, the session
/// waits for grace_s; state packets and inputs go on by UDP as long as datagrams come from the
/// client. Not thread-safe: one thread drives it. Times are seconds of one monotonic clock,
/// server_time_s is the tick clock's time (tick * dt).
class SessionHost {
  public:
    /// Throws std::invalid_argument when a setting is outside its range.
    SessionHost(HostSettings settings, SessionOutput output);
    ~SessionHost();

    /// A stream finished its TLS handshake. The keys derive from its exporter; `loopback` says
    /// whether the peer is local. The time for the login counts from `connected_s`.
    void on_stream_open(StreamId stream, bool loopback, double connected_s);
    /// A WebSocket was opened. It protects what it carries, so datagrams travel in it as they are,
    /// and never by UDP. `local`: the client is on this machine.
    void on_websocket_open(StreamId stream, bool local, double connected_s);
    /// The address of a stream that is open, for figures.
    void set_peer(StreamId stream, const mailbox::Address& address);
    void on_frame(StreamId stream, std::span<const std::uint8_t> frame, double now_s);
    void on_stream_closed(StreamId stream, double now_s);
    /// Datagrams follow that waited together. Of each session only the first few that authenticate
    /// are read, beside as many as it may send in the time `gathered_s` for which they were left to
    /// wait on purpose: given the newest first, a server that is behind spends its time on what is
    /// fresh. Each datagram repeats the commands and acknowledgements of those before it.
    void begin_datagrams(double gathered_s = 0.0);
    /// `arrived_s`: when it reached this machine, at most `now_s`. Round trips are measured by it.
    void on_datagram(const mailbox::Address& from,
                     std::span<const std::uint8_t> datagram,
                     double now_s,
                     double arrived_s);

    void on_datagram(const mailbox::Address& from,
                     std::span<const std::uint8_t> datagram,
                     double now_s) {
        on_datagram(from, datagram, now_s, now_s);
    }

    /// The login of SessionOutput::store_login is stored, or could not be. `place`, world
    /// coordinates in m, is where the character stood when it was here last; none: it is new.
    void on_login_stored(StreamId stream,
                         bool stored,
                         const std::optional<std::array<double, 3>>& place,
                         double now_s);
    /// The login of SessionOutput::store_login is not taken: the client is told why, and where it
    /// goes on.
    void refuse_login(StreamId stream, const std::string& text, const proto::Redirect* redirect);
    /// A session of the process before this one, ascending by client; its grace time begins.
    void restore(KeptSession kept, double now_s);
    /// Later sessions get higher numbers than this.
    void number_sessions_after(ClientId client);
    /// A ticket that was used before this host began.
    void remember_ticket(const TicketNonce& nonce, std::int64_t expires_s);

    /// From the zones. `server_time_s` stamps state packets. A large output is spread over most of
    /// a tick: release() sends the rest.
    void on_outbox(const mailbox::OutboxItem& item, double now_s, double server_time_s);

    /// Sends the packets held back until now. Call at next_release_s().
    void release(double now_s, double server_time_s);
    /// When the next held datagram is due; infinity when none is.
    [[nodiscard]] double next_release_s() const;

    /// Timeouts, grace periods, retransmissions. Call at least ten times a second. `current_tick`
    /// feeds the input gate.
    void tick(double now_s, Tick current_tick);

    /// The Unix time that belongs to `now_s`: tickets are checked by it. Call at start and once a
    /// minute or so; without it Unix time is taken to be `now_s` itself.
    void set_unix_time(double unix_s, double now_s);

    /// Takes back the buffer of a datagram that was sent, to be used again. Optional; the only call
    /// that is allowed from within SessionOutput.
    void recycle(Bytes datagram);

    /// Notifies every client that the server closes, and closes the streams. Later clients are
    /// refused.
    void shutdown(const std::string& text);

    // ---- host_control.cpp: what an operator asks for
    /// Sessions with numbers above `after`, ascending, at most so many.
    [[nodiscard]] std::vector<SessionFigures> figures(ClientId after,
                                                      std::size_t most,
                                                      double now_s) const;
    /// Ends these sessions, whose clients are told why; returns how many there were.
    std::size_t kick(const SessionChoice& who, const std::string& reason);
    /// Ends the account's sessions and refuses its logins; returns how many sessions there were.
    std::size_t ban(AccountBan ban);
    /// False when the account was not banned.
    bool unban(const std::string& account);
    [[nodiscard]] std::vector<AccountBan> bans() const;
    /// Sends a text of the operator as a reliable event to one client, or to all (none); returns to
    /// how many.
    std::size_t notify(ClientId client, const std::string& text);
    /// From now on new logins are refused with this text; sessions go on, and may come back within
    /// their grace time. Empty: logins are taken again.
    void set_draining(const std::string& text);
    /// Holds from now on; sessions beyond a smaller number of places stay.
    void set_limits(const HostLimits& limits);
    /// The load of this server since the last call, as OverloadControl takes it; call a few times a
    /// second. Never called: no login is refused for it.
    void measured(double load, double now_s);
    /// Tickets by this key of the cluster are taken too, where they name this world.
    void trust_cluster(const PublicKey& key);

    // ---- host_travel.cpp: characters that go to another world of the cluster
    [[nodiscard]] std::optional<Traveller> traveller(ClientId client) const;
    /// The client of a login that waits for on_login_stored() or refuse_login().
    [[nodiscard]] std::optional<Traveller> waiting_login(StreamId stream) const;
    /// The avatar leaves the zones for good; the session waits for redirect(). False: there is no
    /// such session, or its avatar has left. `keep_avatar` is a fault on purpose.
    bool begin_travel(ClientId client, bool keep_avatar = false);
    /// Ends the session; its client is told where it goes on.
    void redirect(ClientId client, const std::string& text, const proto::Redirect& redirect);
    /// The client may soon be redirected there.
    void announce(ClientId client, const proto::Redirect& redirect);
    /// Ends all sessions of an account with a ticket but this one.
    std::size_t end_account(const std::string& account, ClientId but, const std::string& text);

    void set_udp_port(std::uint16_t port);
    [[nodiscard]] const HostStats& stats() const;
    /// All sessions, those in their grace time included, ascending.
    [[nodiscard]] std::vector<ClientId> sessions() const;
    [[nodiscard]] RttPercentiles rtt_percentiles() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace zoned::session
