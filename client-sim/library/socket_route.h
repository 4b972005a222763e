// SocketRoute: the way to a server by sockets: the system's, or the game's own.
#pragma once

#include "client-sim/library/game_client.h"
#include "client-sim/link/socket_transport.h"

#include <cstdint>
#include <memory>
#include <string>

namespace zoned::library {

class SocketRoute final : public GameRoute {
  public:
    SocketRoute(std::string host, std::uint16_t port, const GameClientSettings& settings);

    [[nodiscard]] link::Transport& transport() override { return *transport_; }

    [[nodiscard]] const std::string& trouble() const override { return network_.trouble(); }

    void poll(double now_s) override { network_.poll(now_s); }

    void flush() override { network_.flush(); }

  private:
    link::SocketNetwork network_;
    std::unique_ptr<link::SocketTransport> transport_;
};

}  // namespace zoned::library
