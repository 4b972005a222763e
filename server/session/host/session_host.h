// SessionHost: all sessions of a server; bytes in, bytes out, no sockets: net and the test harness
// both drive it.
#pragma once

#include "server/mailbox/messages.h"
#include "server/session/datagrams/rate_control.h"
#include "proto/session.pb.h"
#include "shared/core/ids.h"
#include "shared/wire/seal.h"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::session {

using Bytes = std::vector<std::uint8_t>;

/// An accepted TCP connection, numbered by whoever accepted it. Zero = none.
using StreamId = StrongId<struct StreamTag, std::uint64_t>;

/// Where a datagram came from or goes to: IPv6 or v4-mapped address, port. The harness invents its
/// own.
struct PeerAddress {
    std::uint8_t ip[16] = {};
    std::uint16_t port = 0;

    friend auto operator<=>(const PeerAddress&, const PeerAddress&) = default;
};

/// Faults on purpose, so that what checks clients can be checked.
struct Faults {
    double drop_event_probability = 0.0;    ///< uses up an event's number and never sends it
    double double_event_probability = 0.0;  ///< sends an event twice, under consecutive numbers
    std::uint64_t seed = 1;
};

struct HostSettings {
    std::uint32_t max_sessions = 20000;
    double grace_s = 30.0;  ///< how long a session waits for its client to come back
    double login_timeout_s = 10.0;
    double silence_timeout_s =
        15.0;  ///< neither datagram nor frame for this long: the stream is closed, the grace begins
    std::size_t max_frame_bytes = 65536;    ///< of a client's frame
    std::size_t max_unacked_events = 4096;  ///< more: the client is too slow, it is closed
    std::uint32_t max_commands_per_s =
        20;  ///< reliable commands per client; flood limit (burst: 2 s worth)
    std::uint32_t max_datagrams_per_s = 120;
    std::uint32_t max_frames_per_s = 400;  ///< of any kind; more than twice that at once: closed
    std::size_t max_command_bytes = 4096;  ///< payload of one reliable command
    std::size_t max_tunnel_backlog_bytes =
        65536;  ///< no state packet goes into a stream in which more than this waits
    std::size_t max_remembered_tickets = 1'000'000;  ///< used, not yet expired
    bool dev_mode_loopback =
        false;  ///< lets in loopback addresses without a ticket, with all rights in dev_rights
    std::uint32_t dev_rights = mailbox::kRightPlay;
    std::vector<std::array<std::uint8_t, 32>>
        ticket_keys;  ///< Ed25519 public keys whose tickets are accepted
    std::uint32_t protocol_version = 4;
    std::string config_digest;
    proto::WorldDescription world;
    double tick_rate_hz = 30.0;
    Tick input_window_ticks =
        32;  ///< commands farther ahead of the current tick are refused; older than 8 ticks too;
             ///< at most kMaxInputWindowTicks (input_gate.h)
    RateSettings rate;  ///< what each client's path is given, as long as it carries it
    Faults testing;
};

/// What goes out. The host calls these from within its own calls; they must not call back.
struct SessionOutput {
    std::function<void(StreamId, Bytes frame)>
        send_frame;  ///< serialised ServerMessage, without the length prefix
    std::function<void(StreamId)> close_stream;  ///< after all frames before it have been sent
    std::function<void(const PeerAddress&, Bytes datagram)> send_datagram;
    std::function<void(mailbox::InboxItem)> to_zones;
    std::function<std::size_t(StreamId)>
        stream_backlog;  ///< bytes that wait in a stream; may be empty: never any
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
    std::uint64_t resumed = 0;
    std::map<std::string, std::uint64_t>
        rejected;  ///< reason -> count: nothing from outside is dropped without a count
};

/// A session is a login; it outlives its streams. Where a stream ends without Quit, the session
/// waits for grace_s; state packets and inputs go on by UDP as long as the client is heard there.
/// Not thread-safe: one thread drives it. Times are seconds of one monotonic clock, server_time_s
/// is the tick clock's time (tick * dt).
class SessionHost {
  public:
    /// Throws std::invalid_argument when a setting is outside its range.
    SessionHost(HostSettings settings, SessionOutput output);
    ~SessionHost();

    /// A stream finished its TLS handshake. `keys` derive from its exporter; `loopback` says
    /// whether the peer is local.
    void on_stream_open(StreamId stream,
                        bool loopback,
                        const wire::SealKey& down,
                        const wire::SealKey& up,
                        double now_s);
    void on_frame(StreamId stream, std::span<const std::uint8_t> frame, double now_s);
    void on_stream_closed(StreamId stream, double now_s);
    void on_datagram(const PeerAddress& from, std::span<const std::uint8_t> datagram, double now_s);

    /// From the zones. `server_time_s` stamps state packets. What is much at once is spread over
    /// most of a tick: release() sends the rest.
    void on_outbox(const mailbox::OutboxItem& item, double now_s, double server_time_s);

    /// Sends what was held back until now. Call at next_release_s().
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

    /// Tells every client that the server closes, and closes the streams. Whoever comes later is
    /// refused.
    void shutdown(const std::string& text);

    void set_udp_port(std::uint16_t port);
    [[nodiscard]] const HostStats& stats() const;
    /// Sessions with a live stream whose ticket allows audits, ascending.
    [[nodiscard]] std::vector<ClientId> auditable() const;
    /// All sessions, those in their grace time included, ascending.
    [[nodiscard]] std::vector<ClientId> sessions() const;
    [[nodiscard]] RttPercentiles rtt_percentiles() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace zoned::session
