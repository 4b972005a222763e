#include "server/net/tls_listener.h"

#include "server/net/bind_error.h"
#include "server/net/handshake_queue.h"

#include <asio/ip/tcp.hpp>
#include <asio/ip/v6_only.hpp>
#include <asio/steady_timer.hpp>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <map>
#include <optional>
#include <stdexcept>
#include <unordered_map>
#include <utility>

namespace zoned::net {

namespace {

using asio::ip::tcp;
using Clock = std::chrono::steady_clock;

constexpr auto kPauseAfterError = std::chrono::milliseconds(100);
/// Connections taken in one turn of the thread.
constexpr int kAcceptsPerTurn = 16;

Address address_of(const tcp::endpoint& endpoint) {
    sockaddr_storage storage{};
    std::memcpy(&storage, endpoint.data(), endpoint.size());
    return from_socket_address(storage);
}

}  // namespace

struct TlsListener::Impl : std::enable_shared_from_this<TlsListener::Impl> {
    Impl(asio::io_context& io, const TlsSettings& settings_in, TlsCallbacks callbacks_in)
        : settings(settings_in),
          callbacks(std::move(callbacks_in)),
          last_number(settings.number_after),
          acceptor(io),
          pause(io),
          events(std::make_shared<ConnectionEvents>()) {
        if (settings.websocket) {
            gate = std::make_shared<const WebSocketGate>(*settings.websocket);
        }
        if (!settings.plain) {
            files = prepare_certificate(settings.certificate);
            context.emplace(make_server_context(files));
            fingerprint = certificate_fingerprint(*context);
        }
    }

    void bind();
    void connect_events();
    void accept();
    void accept_after(Clock::duration delay);
    void on_accept(const asio::error_code& ec, tcp::socket socket);
    void take(tcp::socket socket);
    void queue(tcp::socket socket, const Address& peer);
    void begin(tcp::socket socket, const Address& peer, HandshakeQueue::Clock::duration spent);
    void on_left(const Address& peer, HandshakeQueue::Left why);
    void forget(const Address& peer);
    void on_gone(StreamConnection& connection, const std::string& reason);
    [[nodiscard]] StreamConnection* find(StreamNumber number) const;

    TlsSettings settings;
    TlsCallbacks callbacks;
    StreamNumber last_number;
    std::shared_ptr<const WebSocketGate> gate;  ///< nullptr: no WebSockets
    CertificateFiles files;
    std::optional<asio::ssl::context> context;  ///< none: plain
    std::string fingerprint;
    tcp::acceptor acceptor;
    asio::steady_timer pause;
    std::shared_ptr<ConnectionEvents> events;
    std::unordered_map<StreamNumber, std::shared_ptr<StreamConnection>> connections;
    std::shared_ptr<HandshakeQueue> waiting;
    std::map<NetworkKey, std::size_t> per_network;
    std::uint16_t port = 0;
};

void TlsListener::Impl::bind() {
    const auto parsed = parse_address(settings.bind_address, settings.port);
    if (!parsed) {
        throw std::system_error(std::make_error_code(std::errc::invalid_argument), parsed.error());
    }
    if (settings.plain && (!settings.websocket || !parsed->is_loopback())) {
        throw std::runtime_error("without TLS only WebSockets are taken, on a loopback address");
    }
    const auto check = [&](const asio::error_code& ec) {
        if (ec) {
            throw bind_error(ec, "TCP", *parsed);
        }
    };
    const asio::ip::address ip = asio::ip::make_address(settings.bind_address);
    const tcp::endpoint endpoint(ip, settings.port);
    asio::error_code ec;
    acceptor.open(endpoint.protocol(), ec);
    check(ec);
    // A restarted server must not wait for the last one's connections to fade away.
    acceptor.set_option(tcp::acceptor::reuse_address(true), ec);
    check(ec);
    if (ip.is_v6()) {
        acceptor.set_option(asio::ip::v6_only(false), ec);
        check(ec);
    }
    acceptor.bind(endpoint, ec);
    check(ec);
    acceptor.listen(4096, ec);
    check(ec);
    acceptor.non_blocking(true, ec);
    check(ec);
    port = acceptor.local_endpoint(ec).port();
    check(ec);
}

void TlsListener::Impl::connect_events() {
    // The listener outlives none of these: its destructor empties them.
    events->opened = [this](StreamConnection& c) {
        if (!c.is_websocket()) {
            callbacks.on_open(c.number(), c.peer(), c.peer().is_loopback(), c.spent_s());
        } else {
            callbacks.on_websocket(c.number(), c.peer(), c.local(), c.spent_s());
        }
    };
    events->frame = [this](StreamConnection& c, std::span<const std::uint8_t> frame) {
        callbacks.on_frame(c.number(), frame);
    };
    events->closed = [this](StreamConnection& c, const std::string& reason) {
        on_gone(c, reason);
    };
}

void TlsListener::Impl::accept() {
    if (!acceptor.is_open()) {
        return;
    }
    acceptor.async_accept(
        [self = shared_from_this()](const asio::error_code& ec, tcp::socket socket) {
            self->on_accept(ec, std::move(socket));
        });
}

void TlsListener::Impl::accept_after(Clock::duration delay) {
    pause.expires_after(delay);
    pause.async_wait([self = shared_from_this()](const asio::error_code& ec) {
        if (!ec) {
            self->accept();
        }
    });
}

void TlsListener::Impl::on_accept(const asio::error_code& ec, tcp::socket socket) {
    if (!acceptor.is_open()) {
        return;
    }
    if (ec) {
        // Mostly "too many open files": it would only repeat at once.
        ++events->stats.accept_errors;
        accept_after(kPauseAfterError);
        return;
    }
    take(std::move(socket));
    // One in each turn of a busy thread would let a queue of players time out.
    for (int more = 1; more < kAcceptsPerTurn; ++more) {
        asio::error_code none;
        tcp::socket next = acceptor.accept(none);
        if (none) {
            break;
        }
        take(std::move(next));
    }
    accept();
}

void TlsListener::Impl::take(tcp::socket socket) {
    ++events->stats.accepted;
    asio::error_code gone;
    const tcp::endpoint remote = socket.remote_endpoint(gone);
    if (gone) {
        ++events->stats.accept_errors;
    } else {
        queue(std::move(socket), address_of(remote));
    }
}

void TlsListener::Impl::queue(tcp::socket socket, const Address& peer) {
    if (connections.size() + waiting->size() >= settings.max_connections) {
        ++events->stats.refused_total;
        return;
    }
    std::size_t& count = per_network[network_of(peer)];
    if (!peer.is_loopback() && count >= settings.max_connections_per_address) {
        ++events->stats.refused_address;
        return;
    }
    ++count;
    waiting->add(std::move(socket), peer);
}

void TlsListener::Impl::begin(tcp::socket socket,
                              const Address& peer,
                              HandshakeQueue::Clock::duration spent) {
    const StreamNumber number = ++last_number;
    auto connection = std::make_shared<StreamConnection>(std::move(socket),
                                                         context ? &*context : nullptr,
                                                         gate,
                                                         number,
                                                         peer,
                                                         settings.limits,
                                                         spent,
                                                         events);
    connections.emplace(number, connection);
    connection->start();
}

void TlsListener::Impl::on_left(const Address& peer, HandshakeQueue::Left why) {
    switch (why) {
        case HandshakeQueue::Left::kClosed:
            ++events->stats.left_early;
            break;
        case HandshakeQueue::Left::kTimeout:
            ++events->stats.handshake_timeout;
            break;
        case HandshakeQueue::Left::kNoTls:
            ++events->stats.handshake_failed;
            break;
    }
    forget(peer);
}

void TlsListener::Impl::forget(const Address& peer) {
    const auto network = per_network.find(network_of(peer));
    if (network != per_network.end() && --network->second == 0) {
        per_network.erase(network);
    }
}

void TlsListener::Impl::on_gone(StreamConnection& connection, const std::string& reason) {
    const auto it = connections.find(connection.number());
    if (it == connections.end()) {
        return;
    }
    const std::shared_ptr<StreamConnection> keep = it->second;
    connections.erase(it);
    forget(connection.peer());
    if (connection.opened()) {
        callbacks.on_closed(connection.number(), reason);
    }
}

StreamConnection* TlsListener::Impl::find(StreamNumber number) const {
    const auto it = connections.find(number);
    return it == connections.end() ? nullptr : it->second.get();
}

TlsListener::TlsListener(asio::io_context& io, const TlsSettings& settings, TlsCallbacks callbacks)
    : impl_(std::make_shared<Impl>(io, settings, std::move(callbacks))) {
    impl_->bind();
    impl_->connect_events();
    impl_->waiting = std::make_shared<HandshakeQueue>(
        io,
        HandshakeQueueSettings{
            !settings.plain, settings.limits.handshake_timeout_s, settings.max_handshakes_per_s},
        HandshakeQueue::Callbacks{
            [impl = impl_.get()](
                tcp::socket socket, const Address& peer, HandshakeQueue::Clock::duration spent) {
                impl->begin(std::move(socket), peer, spent);
            },
            [impl = impl_.get()](const Address& peer, HandshakeQueue::Left why) {
                impl->on_left(peer, why);
            }});
}

TlsListener::~TlsListener() {
    stop_accepting();
    abort_all();
}

void TlsListener::start() {
    impl_->accept();
}

void TlsListener::stop_accepting() {
    asio::error_code ignored;
    impl_->acceptor.close(ignored);
    impl_->pause.cancel();
    impl_->waiting->clear();
}

void TlsListener::abort_all() {
    impl_->events->opened = nullptr;
    impl_->events->frame = nullptr;
    impl_->events->closed = nullptr;
    for (const auto& [number, connection] : std::exchange(impl_->connections, {})) {
        connection->abort("the server stops");
    }
    impl_->per_network.clear();
}

void TlsListener::send(StreamNumber stream, std::span<const std::uint8_t> frame, SharedBytes tail) {
    if (StreamConnection* connection = impl_->find(stream)) {
        connection->send(frame, std::move(tail));
    }
}

void TlsListener::close(StreamNumber stream) {
    if (StreamConnection* connection = impl_->find(stream)) {
        connection->close();
    }
}

std::size_t TlsListener::backlog(StreamNumber stream) const {
    const StreamConnection* connection = impl_->find(stream);
    return connection == nullptr ? 0 : connection->backlog();
}

void TlsListener::set_origins(std::vector<std::string> origins) {
    impl_->gate = std::make_shared<const WebSocketGate>(WebSocketGate{std::move(origins)});
}

std::uint16_t TlsListener::port() const {
    return impl_->port;
}

const std::string& TlsListener::fingerprint() const {
    return impl_->fingerprint;
}

const CertificateFiles& TlsListener::certificate_files() const {
    return impl_->files;
}

std::size_t TlsListener::connections() const {
    return impl_->connections.size() + impl_->waiting->size();
}

const TlsStats& TlsListener::stats() const {
    return impl_->events->stats;
}

}  // namespace zoned::net
