// Sockets: streams and datagrams of bytes to servers, without waiting: the system's, or a game's.
#pragma once

#include "client-sim/link/link.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace zoned::link {

enum class StreamState : std::uint8_t {
    kOpening,
    kOpen,
    kLost,  ///< trouble() says why
};

/// No call waits. Not thread-safe.
class Sockets {
  public:
    /// Results of send() and receive() in place of a size.
    static constexpr std::ptrdiff_t kEnded = -1;   ///< the other side has ended the stream in order
    static constexpr std::ptrdiff_t kFailed = -2;  ///< trouble() says why

    virtual ~Sockets() = default;

    /// Begins a stream to a name or an address; returns its number. What goes wrong shows in its
    /// state.
    virtual int open(const std::string& host, std::uint16_t port) = 0;
    [[nodiscard]] virtual StreamState state(int stream) const = 0;

    /// Of the stream that was lost, or of the last call that failed.
    [[nodiscard]] virtual std::string trouble(int stream) const = 0;

    /// Whether the stream leads to this machine. Only of an open one.
    [[nodiscard]] virtual bool is_local(int stream) const = 0;

    /// Whether anything may have changed since send() or receive() last said 0.
    [[nodiscard]] virtual bool is_ready(int stream) const = 0;

    /// Bytes that were taken; 0: none now.
    virtual std::ptrdiff_t send(int stream, std::span<const std::uint8_t> bytes) = 0;
    /// Bytes that have come; 0: none now.
    virtual std::ptrdiff_t receive(int stream, std::span<std::uint8_t> into) = 0;
    virtual void close(int stream) = 0;

    /// Looks what has changed.
    virtual void poll() = 0;

    /// From now on the datagrams of this client go to that port of a host to which a stream led.
    virtual void set_peer(std::size_t client, const std::string& host, std::uint16_t port) = 0;
    /// Queues until flush(). Dropped where the client has no peer.
    virtual void queue_datagram(std::size_t client, Bytes datagram) = 0;
    virtual void flush() = 0;
    /// Hands every datagram that waits to `each`.
    virtual void receive_datagrams(
        const std::function<void(std::span<const std::uint8_t>)>& each) = 0;

    /// Datagrams for which there was no room.
    [[nodiscard]] virtual std::uint64_t send_drops() const = 0;
};

}  // namespace zoned::link
