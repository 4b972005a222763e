// Transport: one client's connection to a server as bytes and messages, over sockets or a virtual
// network.
#pragma once

#include "shared/wire/session/session_messages.h"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace zoned::link {

using Bytes = std::vector<std::uint8_t>;

/// Callbacks from a transport to its client. Called from within Transport's own driving calls only.
struct TransportEvents {
    /// Stream is up. `inside`: it is a WebSocket, which protects what it carries: datagrams travel
    /// inside it as they are, and there is no UDP.
    std::function<void(bool inside)> opened;
    std::function<void(Bytes frame)> frame;        ///< one serialised ServerMessage
    std::function<void(Bytes datagram)> datagram;  ///< UDP payload with this client's connection id
    std::function<void(std::string reason)> closed;  ///< stream is gone; empty reason: orderly
};

/// Raw transport of one client: a TLS stream of frames and a UDP path. Implemented by sockets
/// (socket_transport) and by the test harness (virtual network). Not thread-safe.
class Transport {
  public:
    virtual ~Transport() = default;
    virtual void set_events(TransportEvents events) = 0;
    /// Opens (or reopens) the stream; answers with opened() or closed().
    virtual void open() = 0;
    virtual void send_frame(Bytes frame) = 0;
    /// Datagrams go to the server's address and `udp_port`; the connection id lets many clients
    /// share a socket.
    virtual void set_udp(std::uint16_t udp_port, std::uint32_t connection_id) = 0;
    virtual void send_datagram(Bytes datagram) = 0;
    virtual void close() = 0;

    /// The client may soon be redirected to this server: a stream to it is opened beside the
    /// present one, so that a redirect finds it open. Nothing happens where that cannot be.
    virtual void prepare(const std::string& host,
                         std::uint16_t port,
                         const std::string& certificate_sha256) {
        (void)host;
        (void)port;
        (void)certificate_sha256;
    }

    /// Whether the stream that the next open() opens is open already, by prepare().
    [[nodiscard]] virtual bool prepared() const { return false; }

    /// The next open() goes to this server (no host: the present one); `certificate_sha256` (32
    /// bytes, or empty) is what a client that trusts by a pin expects there. False: this transport
    /// knows one server only.
    virtual bool redirect(const std::string& host,
                          std::uint16_t port,
                          const std::string& certificate_sha256) {
        (void)host;
        (void)port;
        (void)certificate_sha256;
        return false;
    }
};

}  // namespace zoned::link
