// SocketRoute: the way to a server by sockets of the library's own.
#pragma once

#include "client-sim/library/game_client.h"
#include "client-sim/library/game_route.h"
#include "client-sim/link/name_lookup.h"
#include "client-sim/link/socket_transport.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace zoned::library {

/// Looks the name up without waiting.
class SocketRoute final : public GameRoute {
  public:
    SocketRoute(std::string host, std::uint16_t port, const GameClientSettings& settings);

    [[nodiscard]] link::Transport* transport() override { return transport_.get(); }

    [[nodiscard]] const std::string& trouble() const override { return trouble_; }

    void poll(double now_s) override;
    void flush() override;

  private:
    void open_network(const link::Address& address);

    std::string host_;
    std::string port_;
    const GameClientSettings* settings_;
    std::string trouble_;
    std::optional<link::NameLookup> lookup_;
    std::unique_ptr<link::SocketNetwork> network_;
    std::unique_ptr<link::SocketTransport> transport_;
};

}  // namespace zoned::library
