// UdpPool: a few UDP sockets shared by all clients of the process, read and written in batches.
#pragma once

#include "client-sim/link/link.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace zoned::link {

class UdpPool {
  public:
    /// Opens `sockets` non-blocking sockets of the address family `family` (AF_INET or AF_INET6).
    /// Throws std::runtime_error with a clear message when the system refuses.
    UdpPool(int sockets, int family);
    ~UdpPool();
    UdpPool(const UdpPool&) = delete;
    UdpPool& operator=(const UdpPool&) = delete;

    /// Queues a datagram on socket `index` (modulo their number) until flush().
    void queue(std::size_t index, const sockaddr_storage& to, socklen_t to_size, Bytes datagram);
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
        sockaddr_storage to{};
        socklen_t to_size = 0;
        Bytes bytes;
    };

    void flush_socket(std::size_t index);

    std::vector<int> sockets_;
    std::vector<std::vector<Outgoing>> queues_;
    std::vector<std::uint8_t> slots_;
    std::array<iovec, kBatch> vectors_{};
    std::array<mmsghdr, kBatch> headers_{};
    std::uint64_t send_drops_ = 0;
};

}  // namespace zoned::link
