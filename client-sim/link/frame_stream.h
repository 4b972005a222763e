// FrameStream: one connection that carries frames, whatever is around them.
#pragma once

#include "client-sim/link/link.h"
#include "client-sim/link/sockets/sockets.h"
#include "client-sim/link/tls_session.h"
#include "client-sim/link/trust.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace zoned::link {

/// Larger frames from a server are refused; a world description fits many times over.
inline constexpr std::size_t kMostFrameBytes = 16U << 20U;

/// Callbacks of a stream, from within advance(). Nothing is called after close().
struct StreamEvents {
    std::function<void(bool inside)> opened;  ///< inside: a WebSocket
    std::function<void(Bytes frame)> frame;
    std::function<void(std::string reason)> closed;
};

/// Sockets and TLS settings that the streams of a network share.
struct StreamWorld {
    Sockets& sockets;
    const TlsContext& tls;
};

class FrameStream {
  public:
    virtual ~FrameStream() = default;
    virtual void connect(const std::string& host, std::uint16_t port) = 0;
    virtual void send_frame(const Bytes& frame) = 0;
    /// Sends all queued frames, says goodbye, closes. No event follows; advance() goes on with it.
    virtual void close() = 0;
    /// Receives, and sends what waits. Cheap where there is nothing to do.
    virtual void advance() = 0;
    /// Whether all is over, and the stream may end.
    [[nodiscard]] virtual bool dead() const = 0;
    /// Number of its stream among the sockets; below 0: none.
    [[nodiscard]] virtual int number() const = 0;
};

/// Makes the streams of a network.
using MakeStream = std::shared_ptr<FrameStream> (*)(const StreamWorld& world,
                                                    const Trust& trust,
                                                    StreamEvents events);

/// The part that streams of all framings share: a stream with TLS over it or without, bytes in,
/// queued bytes out, an orderly end.
class SocketStream : public FrameStream {
  public:
    ~SocketStream() override;
    SocketStream(const SocketStream&) = delete;
    SocketStream& operator=(const SocketStream&) = delete;

    void connect(const std::string& host, std::uint16_t port) final;
    void close() final;
    void advance() final;

    [[nodiscard]] bool dead() const final { return dead_; }

    [[nodiscard]] int number() const final { return number_; }

  protected:
    /// `plain_at_home`: without TLS where the server is on this machine.
    SocketStream(const StreamWorld& world, Trust trust, StreamEvents events, bool plain_at_home);

    /// The bytes' way is open and the server is the trusted one. A framing queues or tells what
    /// comes first; it may fail().
    virtual void on_open() = 0;
    /// Where the next bytes go, not empty.
    virtual std::span<std::uint8_t> room() = 0;
    /// So many bytes have come there; the framing may fail().
    virtual void on_bytes(std::size_t size) = 0;

    /// Queues the framing's own last word, which goes before the stream ends.
    virtual void say_goodbye() {}

    /// Sends what is in `pending_`, once the stream is open.
    void write();
    void fail(const std::string& reason);

    [[nodiscard]] bool done() const { return dead_ || closing_; }

    std::optional<TlsSession> tls_;  ///< none: plain
    Trust trust_;
    StreamEvents events_;
    std::vector<std::uint8_t> pending_;

  private:
    void open();
    void read();
    void finish();
    TlsResult receive(std::span<std::uint8_t> into, std::size_t& size);
    TlsResult send(std::span<const std::uint8_t> bytes, std::size_t& size);
    TlsResult plain_result(std::ptrdiff_t done, std::size_t& size);
    [[nodiscard]] std::string trouble() const;

    StreamWorld world_;
    int number_ = -1;
    bool plain_at_home_;
    bool shaking_ = false;
    bool open_ = false;
    bool closing_ = false;
    bool shut_ = false;  // all is sent, and the server's own end is awaited
    bool dead_ = false;
};

/// Frames with their length before them, over TLS.
[[nodiscard]] std::shared_ptr<FrameStream> make_tls_stream(const StreamWorld& world,
                                                           const Trust& trust,
                                                           StreamEvents events);

/// Frames are messages of a WebSocket, as a browser sends them: without TLS where the server is on
/// this machine.
[[nodiscard]] std::shared_ptr<FrameStream> make_websocket_stream(const StreamWorld& world,
                                                                 const Trust& trust,
                                                                 StreamEvents events);

}  // namespace zoned::link
