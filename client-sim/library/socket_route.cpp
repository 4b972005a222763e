#include "client-sim/library/socket_route.h"

#include <utility>

namespace zoned::library {

SocketRoute::SocketRoute(std::string host, std::uint16_t port, const GameClientSettings& settings)
    : host_(std::move(host)),
      port_(std::to_string(port)),
      settings_(&settings) {
    lookup_.emplace(host_, port_);
}

void SocketRoute::open_network(const link::Address& address) {
    lookup_.reset();
    if (!address) {
        trouble_ = address.error();
        return;
    }
    link::NetworkSettings network;
    network.host = host_;
    network.port = port_;
    network.endpoint = *address;
    network.ca_file = settings_->ca_file;
    network.udp_sockets = 1;
    network.trust.pin = settings_->pin;
    const bool anyone = link::is_loopback(host_) && settings_->ca_file.empty();
    network.trust.kind = settings_->trust.value_or(anyone ? link::Trust::TrustKind::kInsecure
                                                          : link::Trust::TrustKind::kVerify);
    network_ = std::make_unique<link::SocketNetwork>(std::move(network));
    transport_ = network_->make_transport();
}

void SocketRoute::poll(double now_s) {
    if (lookup_) {
        if (const auto address = lookup_->answer()) {
            open_network(*address);
        }
    }
    if (network_) {
        network_->poll(now_s);
    }
}

void SocketRoute::flush() {
    if (network_) {
        network_->flush();
    }
}

}  // namespace zoned::library
