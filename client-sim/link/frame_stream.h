// FrameStream: one connection that carries frames, whatever is around them.
#pragma once

// clang-format off
#include <coroutine>  // before asio, which clang++ needs to find its coroutines
#include <asio.hpp>
#include <asio/ssl.hpp>
// clang-format on

#include "client-sim/link/link.h"
#include "client-sim/link/trust.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::link {

/// Larger frames from a server are refused; a world description fits many times over.
inline constexpr std::size_t kMostFrameBytes = 16U << 20U;

/// Callbacks of a stream. Nothing is called after close().
struct StreamEvents {
    std::function<void(const wire::SealKey& down, const wire::SealKey& up)> opened;
    std::function<void()> opened_inside;  ///< a WebSocket: it has no keys
    std::function<void(Bytes frame)> frame;
    std::function<void(std::string reason)> closed;
};

class FrameStream {
  public:
    virtual ~FrameStream() = default;
    virtual void connect(const asio::ip::tcp::endpoint& endpoint) = 0;
    virtual void send_frame(const Bytes& frame) = 0;
    /// Sends all queued frames, says goodbye, closes. No event follows.
    virtual void close() = 0;
};

/// Makes the streams of a network.
using MakeStream = std::function<std::shared_ptr<FrameStream>(asio::io_context& io,
                                                              asio::ssl::context& tls,
                                                              const Trust& trust,
                                                              StreamEvents events)>;

using TlsSocket = asio::ssl::stream<asio::ip::tcp::socket>;

/// The part that streams of all framings share: a socket with TLS over it or without, bytes in,
/// queued bytes out, an orderly end.
class SocketStream : public FrameStream, public std::enable_shared_from_this<SocketStream> {
  public:
    void connect(const asio::ip::tcp::endpoint& endpoint) final;
    void close() final;

  protected:
    /// `plain_at_home`: without TLS where the server is on this machine.
    SocketStream(asio::io_context& io,
                 asio::ssl::context& tls,
                 Trust trust,
                 StreamEvents events,
                 bool plain_at_home);

    /// The bytes' way is open and the server is the trusted one. A framing queues or tells what
    /// comes first; it may fail().
    virtual void on_open() = 0;
    /// Where the next bytes go, not empty.
    virtual std::span<std::uint8_t> room() = 0;
    /// So many bytes have come there; the framing may fail().
    virtual void on_bytes(std::size_t size) = 0;

    /// Queues the framing's own last word, which goes before the socket ends.
    virtual void say_goodbye() {}

    /// Sends what is in `pending_`, once the stream is open.
    void write();
    void fail(const std::string& reason);

    [[nodiscard]] bool done() const { return dead_ || closing_; }

    [[nodiscard]] bool dead() const { return dead_; }

    TlsSocket stream_;
    Trust trust_;
    StreamEvents events_;
    std::vector<std::uint8_t> pending_;

  private:
    void handshake();
    void open();
    void read();
    void finish();

    bool plain_at_home_;
    bool plain_ = false;
    std::vector<std::uint8_t> writing_;
    bool open_ = false;
    bool closing_ = false;
    bool dead_ = false;
};

/// Frames are messages of a WebSocket, as a browser sends them: without TLS where the server is on
/// this machine.
[[nodiscard]] std::shared_ptr<FrameStream> make_websocket_stream(asio::io_context& io,
                                                                 asio::ssl::context& tls,
                                                                 const Trust& trust,
                                                                 StreamEvents events);

}  // namespace zoned::link
