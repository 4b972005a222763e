// UdpPool: a few UDP sockets shared by all clients of the process, read and written in batches.
#pragma once

#include "client-sim/link/link.h"
#include "client-sim/link/sockets/name_lookup.h"
#include "shared/core/foreign_handle.h"

#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace zoned::link {

class UdpPool {
  public:
    UdpPool();

    /// Opens `sockets` non-blocking sockets of the address family `family` (AF_INET or AF_INET6).
    /// Once. Empty, or why the system refused.
    std::string open(int sockets, int family);

    /// Queues a datagram on socket `index` (modulo their number) until flush(). Dropped and counted
    /// where none is open.
    void queue(std::size_t index, const SocketAddress& to, Bytes datagram);
    /// Hands everything queued to the kernel (sendmmsg). Datagrams for which the kernel has no room
    /// are dropped and counted, as a network would drop them.
    void flush();
    /// Hands every datagram that waits to `each`.
    void receive(const std::function<void(std::span<const std::uint8_t>)>& each);

    [[nodiscard]] std::uint64_t send_drops() const { return send_drops_; }

  private:
    static constexpr std::size_t kBatch = 64;
    static constexpr std::size_t kSlotBytes = 2048;

    struct Outgoing {
        SocketAddress to;
        Bytes bytes;
    };

    static void close(void* self);
    void flush_socket(std::size_t index);

    std::vector<int> sockets_;
    std::vector<std::vector<Outgoing>> queues_;
    std::vector<std::uint8_t> slots_;
    std::array<iovec, kBatch> vectors_{};
    std::array<mmsghdr, kBatch> headers_{};
    std::uint64_t send_drops_ = 0;
    core::ForeignHandle fds_;  // all sockets
};

}  // namespace zoned::link
