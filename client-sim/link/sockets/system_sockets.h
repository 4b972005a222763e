// SystemSockets: streams and datagrams by the sockets of the operating system.
#pragma once

#include "client-sim/link/sockets/name_lookup.h"
#include "client-sim/link/sockets/sockets.h"
#include "client-sim/link/sockets/udp_pool.h"
#include "shared/core/foreign_handle.h"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace zoned::link {

class SystemSockets final : public Sockets {
  public:
    /// `may_start_threads`: names are looked up on a thread each. Else a stream to a name is lost
    /// at once.
    SystemSockets(int udp_sockets, bool may_start_threads);

    /// Streams to this name go to that address from now on.
    void set_address(const std::string& host, const SocketAddress& address);

    /// Opens the sockets for datagrams, which set_peer() does as well. Empty, or why it failed.
    std::string open_udp(bool v4);

    int open(const std::string& host, std::uint16_t port) override;
    [[nodiscard]] StreamState state(int stream) const override;
    [[nodiscard]] std::string trouble(int stream) const override;
    [[nodiscard]] bool is_local(int stream) const override;
    [[nodiscard]] bool is_ready(int stream) const override;
    std::ptrdiff_t send(int stream, std::span<const std::uint8_t> bytes) override;
    std::ptrdiff_t receive(int stream, std::span<std::uint8_t> into) override;
    void close(int stream) override;
    void poll() override;
    void set_peer(std::size_t client, const std::string& host, std::uint16_t port) override;
    void queue_datagram(std::size_t client, Bytes datagram) override;
    void flush() override;
    void receive_datagrams(const std::function<void(std::span<const std::uint8_t>)>& each) override;
    [[nodiscard]] std::uint64_t send_drops() const override;

  private:
    struct SystemStream {
        int fd = -1;
        bool used = false;
        StreamState state = StreamState::kOpening;
        bool readable = false;
        bool writable = false;
        SocketAddress address;
        std::string host;  // while it is looked up
        std::unique_ptr<NameLookup> lookup;
        std::string trouble;
        int error = 0;  // of the last call that failed
    };

    [[nodiscard]] std::optional<SocketAddress> address_of(const std::string& host) const;
    void connect(SystemStream& stream, const SocketAddress& address);
    void look(SystemStream& stream);
    void lose(SystemStream& stream, std::string why);
    std::ptrdiff_t outcome(SystemStream& stream, std::ptrdiff_t done, bool& flag);
    static void close_fds(void* self);

    bool may_start_threads_;
    int udp_sockets_;
    std::map<std::string, SocketAddress> names_;  // that were looked up
    std::vector<SystemStream> streams_;           // by number
    int epoll_ = -1;
    std::optional<UdpPool> udp_;
    std::vector<SocketAddress> peers_;  // by client
    core::ForeignHandle fds_;           // all of the above
};

}  // namespace zoned::link
