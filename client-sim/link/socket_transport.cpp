#include "client-sim/link/socket_transport.h"

#include "client-sim/link/sockets/system_sockets.h"
#include "shared/wire/packet.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace zoned::link {

namespace {

/// For so long a stream that was closed may say its last words.
constexpr double kLastWordsS = 2.0;

}  // namespace

SocketNetwork::SocketNetwork(NetworkSettings settings)
    : SocketNetwork(std::move(settings), nullptr) {
    auto sockets = std::make_unique<SystemSockets>(settings_.udp_sockets, true);
    if (trouble_.empty()) {
        const Address found = look_up(settings_.host, port_);
        if (found) {
            address_ = *found;
            sockets->set_address(settings_.host, address_);
            trouble_ = sockets->open_udp(address_.is_v4());
        } else {
            trouble_ = found.error();
        }
    }
    sockets_ = std::move(sockets);
}

SocketNetwork::SocketNetwork(NetworkSettings settings, std::unique_ptr<Sockets> sockets)
    : settings_(std::move(settings)),
      sockets_(std::move(sockets)),
      tls_(settings_.trust.kind == Trust::TrustKind::kVerify, settings_.ca_file),
      port_(static_cast<std::uint16_t>(std::strtoul(settings_.port.c_str(), nullptr, 10))) {
    trouble_ = tls_.trouble();
    if (settings_.trust.host.empty()) {
        settings_.trust.host = settings_.host;
    }
}

SocketNetwork::~SocketNetwork() = default;

std::unique_ptr<SocketTransport> SocketNetwork::make_transport() {
    auto transport = std::make_unique<SocketTransport>(*this, made_++);
    transports_.push_back(transport.get());
    return transport;
}

void SocketNetwork::on_datagram(std::span<const std::uint8_t> datagram) {
    const auto header = wire::read_datagram_header(datagram);
    if (!header) {
        return;
    }
    const auto found = by_connection_.find(header->connection);
    if (found == by_connection_.end()) {
        return;
    }
    SocketTransport& transport = *found->second;
    if (transport.events_.datagram) {
        transport.events_.datagram({datagram.begin(), datagram.end()});
    }
}

void SocketNetwork::poll(double now_s) {
    now_s_ = now_s;
    sockets_->poll();
    // By index: a client that hears of an end may end its transport.
    for (std::size_t i = 0; i < transports_.size(); ++i) {
        transports_[i]->advance();
    }
    for (const LeavingStream& leaving : leaving_) {
        leaving.stream->advance();
    }
    std::erase_if(leaving_, [&](const LeavingStream& leaving) {
        return leaving.stream->dead() || now_s > leaving.until_s;
    });
    sockets_->receive_datagrams(
        [this](std::span<const std::uint8_t> datagram) { on_datagram(datagram); });
}

void SocketNetwork::close(std::shared_ptr<FrameStream> stream) {
    stream->close();
    if (!stream->dead()) {
        leaving_.push_back({std::move(stream), now_s_ + kLastWordsS});
    }
}

void SocketNetwork::flush() {
    sockets_->flush();
}

SocketTransport::SocketTransport(SocketNetwork& network, std::uint64_t index)
    : network_(network),
      index_(index),
      route_(std::make_shared<ServerRoute>()) {
    route_->host = network.settings_.host;
    route_->port = network.port_;
    route_->trust = network.settings_.trust;
}

SocketTransport::~SocketTransport() {
    events_ = {};
    close();
    drop_ahead();
    network_.by_connection_.erase(connection_);
    std::erase(network_.transports_, this);
}

void SocketTransport::set_events(TransportEvents events) {
    events_ = std::move(events);
}

void SocketTransport::open() {
    const bool was_prepared = route_->stream && !route_->is_used;
    if (!was_prepared) {
        close();
    }
    route_->is_used = true;
    if (!was_prepared) {  // else the next poll reports that it is open
        start(*route_);
    }
}

StreamEvents SocketTransport::events_of(ServerRoute* to) {
    StreamEvents events;
    events.opened = [this, to](bool inside) {
        to->is_inside = inside;
        to->is_open = true;
        report_open();
    };
    events.frame = [this, to](Bytes frame) {
        if (!to->is_used) {
            return;  // a server says nothing before Hello
        }
        if (events_.frame) {
            events_.frame(std::move(frame));
        }
    };
    events.closed = [this, to](std::string reason) {
        lose(*to, std::move(reason));
    };
    return events;
}

/// The stream that is used is open.
void SocketTransport::report_open() {
    if (!route_->is_used || !route_->is_open) {
        return;
    }
    route_->is_open = false;
    if (events_.opened) {
        events_.opened(route_->is_inside);
    }
}

void SocketTransport::lose(ServerRoute& route, std::string reason) {
    route.stream.reset();
    route.is_open = false;
    if (!route.is_used) {
        return;
    }
    if (events_.closed) {
        events_.closed(std::move(reason));
    }
}

void SocketTransport::start(ServerRoute& route) {
    route.stream = network_.settings_.make_stream(
        {*network_.sockets_, network_.tls_}, route.trust, events_of(&route));
    route.stream->connect(route.host, route.port);
}

void SocketTransport::advance() {
    // Copies: a client that hears of an end may end its route, and this transport.
    const std::shared_ptr<ServerRoute> ahead = ahead_;
    const std::shared_ptr<ServerRoute> route = route_;
    if (ahead && ahead->stream) {
        const std::shared_ptr<FrameStream> stream = ahead->stream;
        stream->advance();
    }
    report_open();
    if (const std::shared_ptr<FrameStream> stream = route->stream) {
        stream->advance();
    }
}

std::shared_ptr<SocketTransport::ServerRoute> SocketTransport::route_to(
    const std::string& host,
    std::uint16_t port,
    const std::string& certificate_sha256) const {
    auto route = std::make_shared<ServerRoute>();
    route->host = host.empty() ? route_->host : host;
    route->port = port;
    route->certificate = certificate_sha256;
    route->trust = route_->trust;
    if (!host.empty()) {
        route->trust.host = host;
    }
    // A client that trusts by a pin got the other server's from a server that it trusts.
    if (route->trust.kind == Trust::TrustKind::kPin && certificate_sha256.size() == 32) {
        route->trust.pin.assign(certificate_sha256.begin(), certificate_sha256.end());
    }
    return route;
}

bool SocketTransport::leads_ahead(const std::string& host,
                                  std::uint16_t port,
                                  const std::string& certificate_sha256) const {
    return ahead_ && ahead_->stream && ahead_->host == (host.empty() ? route_->host : host) &&
           ahead_->port == port && ahead_->certificate == certificate_sha256;
}

void SocketTransport::prepare(const std::string& host,
                              std::uint16_t port,
                              const std::string& certificate_sha256) {
    if (leads_ahead(host, port, certificate_sha256)) {
        return;
    }
    drop_ahead();
    ahead_ = route_to(host, port, certificate_sha256);
    start(*ahead_);
}

void SocketTransport::drop_ahead() {
    if (ahead_ && ahead_->stream) {
        network_.close(std::move(ahead_->stream));
    }
    ahead_.reset();
}

bool SocketTransport::redirect(const std::string& host,
                               std::uint16_t port,
                               const std::string& certificate_sha256) {
    close();
    if (leads_ahead(host, port, certificate_sha256)) {
        route_ = std::exchange(ahead_, nullptr);
    } else {
        route_ = route_to(host, port, certificate_sha256);
    }
    return true;
}

void SocketTransport::send_frame(Bytes frame) {
    if (route_->stream) {
        route_->stream->send_frame(frame);
    }
}

void SocketTransport::set_udp(std::uint16_t udp_port, std::uint32_t connection_id) {
    network_.by_connection_.erase(connection_);
    connection_ = connection_id;
    network_.by_connection_[connection_id] = this;
    network_.sockets_->set_peer(index_, route_->host, udp_port);
}

void SocketTransport::send_datagram(Bytes datagram) {
    network_.sockets_->queue_datagram(index_, std::move(datagram));
}

void SocketTransport::close() {
    if (route_->stream) {
        route_->is_open = false;
        network_.close(std::move(route_->stream));
    }
}

}  // namespace zoned::link
