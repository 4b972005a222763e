// StreamConnection: one accepted stream of frames: TLS 1.3 with length prefixes (u32,
// little-endian), or a WebSocket whose binary messages are the frames.
#pragma once

#include "server/net/socket_address.h"
#include "server/net/web_stream.h"
#include "shared/core/token_bucket.h"
#include "shared/wire/websocket/websocket_frames.h"

#include <asio/steady_timer.hpp>

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::net {

/// Bytes that many connections send, kept once.
using SharedBytes = std::shared_ptr<const std::vector<std::uint8_t>>;

/// Number of an accepted stream, from 1, never used twice.
using StreamNumber = std::uint64_t;

struct ConnectionLimits {
    double handshake_timeout_s = 10.0;  ///< for the first message and the handshake together
    double close_timeout_s = 3.0;       ///< for an orderly end; after it the socket is just closed
    std::size_t max_frame_bytes = 65536;  ///< of frames that come in
    /// Waiting to be sent, shared bytes not counted; more: the connection is closed.
    std::size_t max_queue_bytes = 1u << 20;
};

/// The ends of connections by reason, and the bytes that went through them.
struct TlsStats {
    std::uint64_t accepted = 0;
    std::uint64_t opened = 0;  ///< finished the handshake
    std::uint64_t refused_total = 0;
    std::uint64_t refused_address = 0;
    std::uint64_t accept_errors = 0;
    std::uint64_t left_early = 0;  ///< closed by the client before its first message was there
    std::uint64_t handshake_failed = 0;
    std::uint64_t handshake_timeout = 0;
    std::uint64_t frame_oversize = 0;
    std::uint64_t queue_overflow = 0;
    std::uint64_t close_timeout = 0;
    std::uint64_t bytes_in = 0;  ///< inside TLS
    std::uint64_t bytes_out = 0;
    /// WebSockets that were not opened, or were ended for a fault of the client, by reason.
    std::map<std::string, std::uint64_t, std::less<>> websocket_refused;
};

/// Adds the connections that were refused or ended for a limit to counts by reason.
void add_refusals(const TlsStats& stats, std::map<std::string, std::uint64_t>& counts);

/// The reasons that add_refusals() knows.
std::vector<std::string> refusal_reasons();

/// The rule by which a WebSocket is let in.
struct WebSocketGate {
    /// Pages of these sites may connect ("https://play.example"). A client that is no browser sends
    /// no origin, and is let in as over TCP.
    std::vector<std::string> origins;
};

class StreamConnection;

/// The callbacks of a connection to its listener; shared, so that pending handlers outlive neither.
struct ConnectionEvents {
    std::function<void(StreamConnection&)> opened;
    std::function<void(StreamConnection&, std::span<const std::uint8_t>)> frame;
    std::function<void(StreamConnection&, const std::string&)>
        closed;  ///< once, whether opened or not
    TlsStats stats;
};

/// Not thread-safe: driven by the thread of its io_context. Events never come from within send() or
/// close(), so their callers need not expect to be called back.
class StreamConnection : public std::enable_shared_from_this<StreamConnection> {
  public:
    using Clock = std::chrono::steady_clock;

    /// Without a context: plain. With a gate: a WebSocket. `spent`: of the time for the handshake.
    StreamConnection(asio::ip::tcp::socket socket,
                     asio::ssl::context* context,
                     std::shared_ptr<const WebSocketGate> gate,
                     StreamNumber number,
                     const Address& peer,
                     const ConnectionLimits& limits,
                     Clock::duration spent,
                     std::shared_ptr<ConnectionEvents> events);

    void start();
    /// Queues a frame, which may end with a shared tail; silently nothing once the connection is
    /// closing. The tail is sent slice by slice: the backlog tells how far the peer has come.
    void send(std::span<const std::uint8_t> frame, SharedBytes tail = nullptr);
    /// Ends in order: sends the queue, then TLS close_notify, then waits for the peer's end.
    void close();
    /// Ends at once.
    void abort(const std::string& reason);

    [[nodiscard]] StreamNumber number() const { return number_; }

    [[nodiscard]] const Address& peer() const { return peer_; }

    /// The client is on this machine, and no proxy says that it passes on another's bytes.
    [[nodiscard]] bool local() const { return peer_.is_loopback() && !forwarded_; }

    [[nodiscard]] bool opened() const { return opened_; }

    [[nodiscard]] bool is_websocket() const { return gate_ != nullptr; }

    /// How long the client has taken so far, without its wait for a turn, s.
    [[nodiscard]] double spent_s() const {
        return std::chrono::duration<double>(Clock::now() - since_).count();
    }

    /// Bytes that wait to be sent.
    [[nodiscard]] std::size_t backlog() const { return queued_ + writing_.size() + shared_; }

  private:
    enum class ConnectionState : std::uint8_t {
        kHandshake,  ///< of TLS, then of the WebSocket
        kOpen,
        kClosing,
        kDone,
    };

    /// Frames in a row, the last of them with a tail or without.
    struct QueuedFrames {
        std::vector<std::uint8_t> own;
        SharedBytes tail;
    };

    void on_handshake(const asio::error_code& ec);
    void read();
    void on_read(const asio::error_code& ec, std::size_t bytes);
    /// Hands over the whole frames in the buffer; false when the connection is no longer open.
    bool take_frames();
    void open();

    // ---- stream_websocket.cpp
    void read_upgrade();
    void on_upgrade_read(const asio::error_code& ec, std::size_t bytes);
    void answer_upgrade(std::size_t length);
    void refuse_upgrade(unsigned status, std::string_view reason, std::string_view text);
    bool take_messages();
    bool take_item(const wire::WebSocketItem& item);
    /// Sends Close with this code, and ends in order.
    void close_websocket(std::uint16_t code, std::string_view reason, std::string_view text);
    void count_refused(std::string_view reason);

    void append_prefix(std::vector<std::uint8_t>& out, std::uint64_t length) const;
    void append_control(wire::WebSocketOpcode opcode, std::span<const std::uint8_t> payload);
    void start_writing();
    void write();
    void write_slice();
    void on_written(const asio::error_code& ec, std::size_t bytes);
    void shut_down();
    void linger();
    void discard();
    void arm_deadline(double seconds);
    void finish(const std::string& reason);

    WebStream stream_;
    std::shared_ptr<const WebSocketGate> gate_;  ///< nullptr: no WebSocket
    std::optional<wire::WebSocketReader> reader_;
    core::TokenBucket control_frames_;
    bool forwarded_ = false;
    bool close_sent_ = false;
    asio::steady_timer deadline_;
    StreamNumber number_;
    Address peer_;
    ConnectionLimits limits_;
    Clock::time_point since_;
    std::shared_ptr<ConnectionEvents> events_;
    ConnectionState state_ = ConnectionState::kHandshake;
    bool opened_ = false;
    bool reading_ = false;
    bool write_in_progress_ = false;
    bool shutting_down_ = false;
    std::vector<std::uint8_t> in_;
    std::size_t filled_ = 0;
    std::deque<QueuedFrames> pending_;
    std::vector<std::uint8_t> writing_;  ///< handed to TLS
    SharedBytes tail_;                   ///< follows what is handed to TLS
    std::size_t tail_sent_ = 0;
    std::size_t queued_ = 0;  ///< own bytes of pending_
    std::size_t shared_ = 0;  ///< bytes of tails that are not sent yet
};

}  // namespace zoned::net
