// FrameStream: one connection that carries frames, whatever is around them.
#pragma once

// clang-format off
#include <coroutine>  // before asio, which clang++ needs to find its coroutines
#include <asio.hpp>
#include <asio/ssl.hpp>
// clang-format on

#include "client-sim/link/link.h"
#include "client-sim/link/trust.h"

#include <functional>
#include <memory>
#include <string>

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

/// What a connection by TLS must know of its trust before the handshake.
void prepare_trust(TlsSocket& stream, const Trust& trust);
/// Empty: after the handshake the certificate is the pinned one, or none is pinned.
[[nodiscard]] std::string check_pin(TlsSocket& stream, const Trust& trust);

}  // namespace zoned::link
