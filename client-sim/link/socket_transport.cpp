#include "client-sim/link/socket_transport.h"

#include "client-sim/link/name_lookup.h"
#include "client-sim/link/tls_stream.h"
#include "shared/wire/packet.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace zoned::link {

SocketNetwork::SocketNetwork(NetworkSettings settings)
    : settings_(std::move(settings)),
      tls_(asio::ssl::context::tls_client) {
    SSL_CTX_set_min_proto_version(tls_.native_handle(), TLS1_3_VERSION);
    asio::error_code error;
    if (settings_.trust.kind == Trust::TrustKind::kVerify) {
        if (settings_.ca_file.empty()) {
            tls_.set_default_verify_paths(error);
        } else {
            tls_.load_verify_file(settings_.ca_file, error);
        }
        if (error) {
            throw std::runtime_error("cannot read the certificate authorities" +
                                     (settings_.ca_file.empty() ? "" : " in " + settings_.ca_file) +
                                     ": " + error.message());
        }
    }
    if (!settings_.endpoint) {
        const Address found = look_up(settings_.host, settings_.port);
        if (!found) {
            throw std::runtime_error(found.error());
        }
        settings_.endpoint = *found;
    }
    endpoint_ = *settings_.endpoint;
    settings_.trust.host = settings_.host;
    udp_ = std::make_unique<UdpPool>(settings_.udp_sockets,
                                     endpoint_.address().is_v4() ? AF_INET : AF_INET6);
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
    Bytes bytes(datagram.begin(), datagram.end());
    if (transport.conditioned_) {
        transport.down_datagrams_.push(now_s_, std::move(bytes));
    } else if (transport.events_.datagram) {
        transport.events_.datagram(std::move(bytes));
    }
}

void SocketNetwork::poll(double now_s) {
    now_s_ = now_s;
    io_.restart();
    io_.poll();
    udp_->receive([this](std::span<const std::uint8_t> datagram) { on_datagram(datagram); });
    if (settings_.conditioner.active()) {
        for (SocketTransport* transport : transports_) {
            transport->release(now_s);
        }
    }
    // A copy: a client that hears that a name is unknown may end its transport.
    const std::vector<SocketTransport*> waiting = transports_;
    for (SocketTransport* transport : waiting) {
        transport->advance();
    }
}

void SocketNetwork::flush() {
    if (settings_.conditioner.active()) {
        for (SocketTransport* transport : transports_) {
            transport->release(now_s_);
        }
    }
    udp_->flush();
}

std::vector<BottleneckMeter> SocketNetwork::bottlenecks(Direction direction) const {
    std::vector<BottleneckMeter> meters;
    for (const SocketTransport* transport : transports_) {
        const Conditioner& path =
            direction == Direction::kUp ? transport->up_datagrams_ : transport->down_datagrams_;
        if (transport->to_size_ != 0) {
            meters.push_back(path.bottleneck(now_s_));
        }
    }
    return meters;
}

SocketTransport::SocketTransport(SocketNetwork& network, std::uint64_t index)
    : network_(network),
      index_(index),
      route_(std::make_shared<ServerRoute>()),
      conditioned_(network.settings_.conditioner.active()),
      up_datagrams_(network.settings_.conditioner, Conditioner::Mode::kDatagrams, 4 * index),
      down_datagrams_(network.settings_.conditioner,
                      Conditioner::Mode::kDatagrams,
                      4 * index + 1,
                      Direction::kDown),
      up_frames_(network.settings_.conditioner, Conditioner::Mode::kFrames, 4 * index + 2),
      down_frames_(network.settings_.conditioner, Conditioner::Mode::kFrames, 4 * index + 3) {
    route_->endpoint = network.endpoint_;
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
    up_frames_.clear();
    down_frames_.clear();
    route_->is_used = true;
    if (!was_prepared) {  // else the next poll reports that it is open
        start(route_);
    }
}

StreamEvents SocketTransport::events_of(ServerRoute* to) {
    StreamEvents events;
    events.opened = [this, to](const wire::SealKey& down, const wire::SealKey& up) {
        to->down = down;
        to->up = up;
        to->is_open = true;
        report_open();
    };
    events.opened_inside = [this, to] {
        to->is_inside = true;
        to->is_open = true;
        report_open();
    };
    events.frame = [this, to](Bytes frame) {
        if (!to->is_used) {
            return;  // a server says nothing before Hello
        }
        if (conditioned_) {
            down_frames_.push(network_.now_s_, std::move(frame));
        } else if (events_.frame) {
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
    if (route_->is_inside && events_.opened_inside) {
        events_.opened_inside();
    } else if (!route_->is_inside && events_.opened) {
        events_.opened(route_->down, route_->up);
    }
}

void SocketTransport::lose(ServerRoute& route, std::string reason) {
    route.stream.reset();
    route.is_open = false;
    if (!route.is_used) {
        return;
    }
    // Messages that the server sent before it closed still count, the goodbye above all.
    Bytes frame;
    while (down_frames_.pop_due(1e300, frame)) {
        if (events_.frame) {
            events_.frame(std::move(frame));
        }
    }
    if (events_.closed) {
        events_.closed(std::move(reason));
    }
}

void SocketTransport::start(std::shared_ptr<ServerRoute> route) {
    const NetworkSettings& settings = network_.settings_;
    StreamEvents events = events_of(route.get());
    if (settings.make_stream) {
        route->stream =
            settings.make_stream(network_.io_, network_.tls_, route->trust, std::move(events));
    } else {
        route->stream = std::make_shared<TlsStream>(
            network_.io_, network_.tls_, route->trust, std::move(events));
    }
    route->waits = true;
    connect(*route);
}

/// At once, or when the name of a redirect is known.
void SocketTransport::connect(ServerRoute& route) {
    if (route.lookup) {
        const std::optional<Address> found = route.lookup->answer();
        if (!found) {
            return;
        }
        route.lookup.reset();
        if (!*found) {
            route.waits = false;
            lose(route, found->error());
            return;
        }
        route.endpoint = **found;
    }
    route.waits = false;
    route.stream->connect(route.endpoint);
}

void SocketTransport::advance() {
    const std::shared_ptr<ServerRoute> ahead = ahead_;
    if (ahead && ahead->waits) {
        connect(*ahead);
    }
    report_open();
    // At last: a client that hears that a name is unknown may end this transport.
    const std::shared_ptr<ServerRoute> route = route_;
    if (route->waits) {
        connect(*route);
    }
}

std::shared_ptr<SocketTransport::ServerRoute> SocketTransport::route_to(
    const std::string& host,
    std::uint16_t port,
    const std::string& certificate_sha256) const {
    auto route = std::make_shared<ServerRoute>();
    route->host = host;
    route->port = port;
    route->certificate = certificate_sha256;
    route->trust = route_->trust;
    route->endpoint = route_->endpoint;
    if (host.empty()) {
        route->endpoint.port(port);
    } else {
        route->lookup = std::make_unique<NameLookup>(host, std::to_string(port));
        route->trust.host = host;
    }
    // A client that trusts by a pin got the other server's from a server that it trusts.
    if (route->trust.kind == Trust::TrustKind::kPin && certificate_sha256.size() == 32) {
        route->trust.pin.assign(certificate_sha256.begin(), certificate_sha256.end());
    }
    return route;
}

bool SocketTransport::leads_to(const ServerRoute& route,
                               const std::string& host,
                               std::uint16_t port,
                               const std::string& certificate_sha256) {
    return route.stream && route.host == host && route.port == port &&
           route.certificate == certificate_sha256;
}

void SocketTransport::prepare(const std::string& host,
                              std::uint16_t port,
                              const std::string& certificate_sha256) {
    if (ahead_ && leads_to(*ahead_, host, port, certificate_sha256)) {
        return;
    }
    drop_ahead();
    ahead_ = route_to(host, port, certificate_sha256);
    start(ahead_);
}

void SocketTransport::drop_ahead() {
    if (ahead_ && ahead_->stream) {
        ahead_->stream->close();
    }
    ahead_.reset();
}

bool SocketTransport::redirect(const std::string& host,
                               std::uint16_t port,
                               const std::string& certificate_sha256) {
    close();
    if (ahead_ && leads_to(*ahead_, host, port, certificate_sha256)) {
        route_ = std::exchange(ahead_, nullptr);
    } else {
        route_ = route_to(host, port, certificate_sha256);
    }
    return true;
}

void SocketTransport::send_frame(Bytes frame) {
    if (conditioned_) {
        up_frames_.push(network_.now_s_, std::move(frame));
    } else if (route_->stream) {
        route_->stream->send_frame(frame);
    }
}

void SocketTransport::set_udp(std::uint16_t udp_port, std::uint32_t connection_id) {
    network_.by_connection_.erase(connection_);
    connection_ = connection_id;
    network_.by_connection_[connection_id] = this;
    if (to_size_ == 0) {
        up_datagrams_.restart_bottleneck_meter(network_.now_s_);
        down_datagrams_.restart_bottleneck_meter(network_.now_s_);
    }
    const asio::ip::udp::endpoint to(route_->endpoint.address(), udp_port);
    to_size_ = static_cast<socklen_t>(to.size());
    std::memcpy(&to_, to.data(), to.size());
}

void SocketTransport::send_datagram(Bytes datagram) {
    if (conditioned_) {
        up_datagrams_.push(network_.now_s_, std::move(datagram));
    } else {
        transmit(std::move(datagram));
    }
}

void SocketTransport::transmit(Bytes datagram) {
    if (to_size_ != 0) {
        network_.udp_->queue(index_, to_, to_size_, std::move(datagram));
    }
}

void SocketTransport::release(double now_s) {
    Bytes bytes;
    while (up_datagrams_.pop_due(now_s, bytes)) {
        transmit(std::move(bytes));
    }
    while (up_frames_.pop_due(now_s, bytes)) {
        if (route_->stream) {
            route_->stream->send_frame(bytes);
        }
    }
    while (down_datagrams_.pop_due(now_s, bytes)) {
        if (events_.datagram) {
            events_.datagram(std::move(bytes));
        }
    }
    while (down_frames_.pop_due(now_s, bytes)) {
        if (events_.frame) {
            events_.frame(std::move(bytes));
        }
    }
}

void SocketTransport::close() {
    if (!route_->stream) {
        return;
    }
    Bytes frame;
    while (up_frames_.pop_due(1e300, frame)) {
        route_->stream->send_frame(frame);
    }
    down_frames_.clear();
    route_->waits = false;
    route_->is_open = false;
    route_->stream->close();
    route_->stream.reset();
}

}  // namespace zoned::link
