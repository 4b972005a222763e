#include "client-sim/library/socket_route.h"

#include "client-sim/library/caller_sockets.h"
#include "client-sim/link/sockets/system_sockets.h"

#include <utility>

namespace zoned::library {

namespace {

link::NetworkSettings network_of(std::string host,
                                 std::uint16_t port,
                                 const GameClientSettings& settings) {
    link::NetworkSettings network;
    network.port = std::to_string(port);
    network.ca_file = settings.ca_file;
    network.trust.pin = settings.pin;
    network.trust.host = settings.server_name;
    const bool anyone = link::is_loopback(host) && settings.ca_file.empty() && !settings.sockets;
    network.trust.kind = settings.trust.value_or(anyone ? link::Trust::TrustKind::kInsecure
                                                        : link::Trust::TrustKind::kVerify);
    network.host = std::move(host);
    return network;
}

std::unique_ptr<link::Sockets> sockets_of(const GameClientSettings& settings) {
    if (settings.sockets) {
        return std::make_unique<CallerSockets>(*settings.sockets);
    }
    return std::make_unique<link::SystemSockets>(1, settings.may_start_threads);
}

}  // namespace

SocketRoute::SocketRoute(std::string host, std::uint16_t port, const GameClientSettings& settings)
    : network_(network_of(std::move(host), port, settings), sockets_of(settings)),
      transport_(network_.make_transport()) {
}

}  // namespace zoned::library
