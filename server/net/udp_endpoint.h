// UdpEndpoint: one UDP socket; datagrams come and go in batches of 64 per system call.
#pragma once

#include "server/net/socket_address.h"

#include <asio/io_context.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace zoned::net {

struct UdpSettings {
    /// Numeric. "::" listens on all addresses of both families.
    std::string bind_address = "::";
    std::uint16_t port = 0;  ///< 0: any free one
    /// Asked of the kernel, which caps them at net.core.rmem_max and wmem_max.
    int receive_buffer_bytes = 8 << 20;
    int send_buffer_bytes = 8 << 20;
};

struct Datagram {
    Address from;
    std::span<const std::uint8_t> bytes;  ///< valid during the callback
    /// When it reached this machine by the kernel's time stamp, s of the steady clock.
    double arrived_s = 0.0;
};

struct UdpStats {
    std::uint64_t received = 0;
    std::uint64_t received_bytes = 0;
    std::uint64_t receive_calls = 0;  ///< system calls that brought at least one datagram
    std::uint64_t sent = 0;
    std::uint64_t sent_bytes = 0;
    std::uint64_t send_calls = 0;
    std::uint64_t truncated = 0;       ///< longer than any of ours: dropped
    std::uint64_t dropped_full = 0;    ///< the kernel's send buffer was full
    std::uint64_t dropped_error = 0;   ///< the kernel refused the datagram (no route, ...)
    std::uint64_t receive_errors = 0;  ///< reported by the kernel while receiving
    int receive_buffer_bytes = 0;      ///< the size that the kernel granted (Linux counts double)
    int send_buffer_bytes = 0;
};

/// Driven by one thread, that of the io_context. Never blocks; a datagram that cannot be sent at
/// once is dropped and counted, as a network would do.
///
/// Datagrams are read as they come, or, while the socket is held, when the owner asks: then they
/// wait in the kernel, and none of them wakes the thread.
class UdpEndpoint {
  public:
    /// Gets all datagrams that waited, in order of arrival (a few thousand at most).
    using OnDatagrams = std::function<void(std::span<const Datagram>)>;

    /// Binds the socket; throws std::system_error with a text for the operator. Nothing is received
    /// before start().
    UdpEndpoint(asio::io_context& io, const UdpSettings& settings, OnDatagrams on_datagrams);
    ~UdpEndpoint();
    UdpEndpoint(const UdpEndpoint&) = delete;
    UdpEndpoint& operator=(const UdpEndpoint&) = delete;

    /// Begins to read datagrams as they come.
    void start();
    /// From now on they wait; their number is bounded by the receive buffer.
    void hold();
    /// Reads what waits, whether held or not.
    void read();
    /// As they come again, those that wait at once.
    void watch();
    /// Closes the socket; callbacks stop. Called by the destructor too.
    void close();

    [[nodiscard]] std::uint16_t port() const;

    /// Copies the datagram (at most kMaxDatagram bytes; longer ones are dropped as errors). It goes
    /// out with the next flush(), or as soon as a batch is full.
    void queue_send(const Address& to, std::span<const std::uint8_t> bytes);
    void flush();

    [[nodiscard]] const UdpStats& stats() const;

    static constexpr std::size_t kBatch = 64;
    static constexpr std::size_t kMaxDatagram = 2048;

  private:
    struct Impl;
    std::shared_ptr<Impl> impl_;  ///< shared with the pending handler
};

}  // namespace zoned::net
