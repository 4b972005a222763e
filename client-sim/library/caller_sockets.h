// CallerSockets: streams and datagrams by functions of the game.
#pragma once

#include "client-sim/library/zoned_client.h"
#include "client-sim/link/sockets/sockets.h"
#include "shared/core/foreign_handle.h"

#include <string>
#include <vector>

namespace zoned::library {

/// Of one client.
class CallerSockets final : public link::Sockets {
  public:
    explicit CallerSockets(const zoned_client_sockets& functions);

    int open(const std::string& host, std::uint16_t port) override;
    [[nodiscard]] link::StreamState state(int stream) const override;
    [[nodiscard]] std::string trouble(int stream) const override;

    /// Only sockets of the system know: those of a game are as good as far away.
    [[nodiscard]] bool is_local(int /*stream*/) const override { return false; }

    [[nodiscard]] bool is_ready(int /*stream*/) const override { return true; }

    std::ptrdiff_t send(int stream, std::span<const std::uint8_t> bytes) override;
    std::ptrdiff_t receive(int stream, std::span<std::uint8_t> into) override;
    void close(int stream) override;

    void poll() override {}

    void set_peer(std::size_t client, const std::string& host, std::uint16_t port) override;
    void queue_datagram(std::size_t client, link::Bytes datagram) override;

    void flush() override {}

    void receive_datagrams(const std::function<void(std::span<const std::uint8_t>)>& each) override;

    [[nodiscard]] std::uint64_t send_drops() const override { return send_drops_; }

  private:
    struct CallersSocket {
        bool used = false;
        int socket = -1;  // the caller's number; below 0: none
    };

    [[nodiscard]] int socket_of(int stream) const {
        return slots_[static_cast<std::size_t>(stream)].socket;
    }

    static void close_all(void* self);

    zoned_client_sockets functions_;
    std::vector<CallersSocket> slots_;  // by our number
    int datagrams_ = -1;
    std::string peer_;  // of the datagrams, with its port
    std::vector<std::uint8_t> datagram_;
    std::uint64_t send_drops_ = 0;
    core::ForeignHandle all_;
};

}  // namespace zoned::library
