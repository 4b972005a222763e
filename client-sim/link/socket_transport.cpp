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
        if (transport->opening_) {
            transport->connect();
        }
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
      endpoint_(network.endpoint_),
      trust_(network.settings_.trust),
      conditioned_(network.settings_.conditioner.active()),
      up_datagrams_(network.settings_.conditioner, Conditioner::Mode::kDatagrams, 4 * index),
      down_datagrams_(network.settings_.conditioner,
                      Conditioner::Mode::kDatagrams,
                      4 * index + 1,
                      Direction::kDown),
      up_frames_(network.settings_.conditioner, Conditioner::Mode::kFrames, 4 * index + 2),
      down_frames_(network.settings_.conditioner, Conditioner::Mode::kFrames, 4 * index + 3) {
}

SocketTransport::~SocketTransport() {
    events_ = {};
    close();
    network_.by_connection_.erase(connection_);
    std::erase(network_.transports_, this);
}

void SocketTransport::set_events(TransportEvents events) {
    events_ = std::move(events);
}

void SocketTransport::open() {
    close();
    up_frames_.clear();
    down_frames_.clear();
    StreamEvents events;
    events.opened = [this](const wire::SealKey& down, const wire::SealKey& up) {
        if (events_.opened) {
            events_.opened(down, up);
        }
    };
    events.opened_inside = [this] {
        if (events_.opened_inside) {
            events_.opened_inside();
        }
    };
    events.frame = [this](Bytes frame) {
        if (conditioned_) {
            down_frames_.push(network_.now_s_, std::move(frame));
        } else if (events_.frame) {
            events_.frame(std::move(frame));
        }
    };
    events.closed = [this](std::string reason) {
        // Messages that the server sent before it closed still count, the goodbye above all.
        Bytes frame;
        while (down_frames_.pop_due(1e300, frame)) {
            if (events_.frame) {
                events_.frame(std::move(frame));
            }
        }
        stream_.reset();
        if (events_.closed) {
            events_.closed(std::move(reason));
        }
    };
    const NetworkSettings& settings = network_.settings_;
    if (settings.make_stream) {
        stream_ = settings.make_stream(network_.io_, network_.tls_, trust_, std::move(events));
    } else {
        stream_ =
            std::make_shared<TlsStream>(network_.io_, network_.tls_, trust_, std::move(events));
    }
    opening_ = true;
    connect();
}

/// At once, or when the name of a redirect is known.
void SocketTransport::connect() {
    if (lookup_) {
        const std::optional<Address> found = lookup_->answer();
        if (!found) {
            return;
        }
        lookup_.reset();
        if (!*found) {
            opening_ = false;
            stream_.reset();
            if (events_.closed) {
                events_.closed(found->error());
            }
            return;
        }
        endpoint_ = **found;
    }
    opening_ = false;
    stream_->connect(endpoint_);
}

bool SocketTransport::redirect(const std::string& host,
                               std::uint16_t port,
                               const std::string& certificate_sha256) {
    close();
    if (host.empty()) {
        lookup_.reset();
        endpoint_.port(port);
    } else {
        lookup_ = std::make_unique<NameLookup>(host, std::to_string(port));
        trust_.host = host;
    }
    // A client that trusts by a pin got the other server's from a server that it trusts.
    if (trust_.kind == Trust::TrustKind::kPin && certificate_sha256.size() == 32) {
        trust_.pin.assign(certificate_sha256.begin(), certificate_sha256.end());
    }
    return true;
}

void SocketTransport::send_frame(Bytes frame) {
    if (conditioned_) {
        up_frames_.push(network_.now_s_, std::move(frame));
    } else if (stream_) {
        stream_->send_frame(frame);
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
    const asio::ip::udp::endpoint to(endpoint_.address(), udp_port);
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
        if (stream_) {
            stream_->send_frame(bytes);
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
    if (!stream_) {
        return;
    }
    Bytes frame;
    while (up_frames_.pop_due(1e300, frame)) {
        stream_->send_frame(frame);
    }
    down_frames_.clear();
    opening_ = false;
    stream_->close();
    stream_.reset();
}

}  // namespace zoned::link
