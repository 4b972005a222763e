#include "server/admin/admin_server.h"

#include "server/admin/http_connection.h"
#include "server/admin/openapi.h"
#include "server/admin/spectator_service.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

namespace zoned::admin {

namespace asio = boost::asio;
using tcp = boost::asio::ip::tcp;

namespace {

/// Without free file descriptors the listener tries again after this long.
constexpr auto kAcceptAgain = std::chrono::milliseconds(100);
/// With too many connections a second the kernel's queue holds the others for so long.
constexpr auto kAcceptPause = std::chrono::milliseconds(10);

asio::ip::address listen_address(const AdminSettings& settings) {
    boost::system::error_code error;
    const asio::ip::address address = asio::ip::make_address(settings.address, error);
    if (error) {
        throw std::invalid_argument("network.admin_address: '" + settings.address +
                                    "' is no IPv4 or IPv6 address");
    }
    if (!address.is_loopback() && settings.certificate_file.empty()) {
        throw std::invalid_argument("network.admin_address: '" + settings.address +
                                    "' is no loopback address; without a certificate the admin "
                                    "server listens to this machine alone");
    }
    return address;
}

/// Null without a certificate.
std::unique_ptr<asio::ssl::context> tls_context(const AdminSettings& settings) {
    if (settings.certificate_file.empty()) {
        return nullptr;
    }
    auto context = std::make_unique<asio::ssl::context>(asio::ssl::context::tls_server);
    SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_2_VERSION);
    boost::system::error_code error;
    context->use_certificate_chain_file(settings.certificate_file, error);
    if (!error) {
        context->use_private_key_file(settings.key_file, asio::ssl::context::pem, error);
    }
    if (error) {
        throw std::runtime_error("the admin server's certificate " + settings.certificate_file +
                                 " with its key " + settings.key_file +
                                 " cannot be used: " + error.message());
    }
    return context;
}

std::system_error listen_error(const boost::system::error_code& error,
                               const AdminSettings& settings) {
    return std::system_error(error.value(),
                             std::generic_category(),
                             "cannot listen on TCP " + settings.address + ":" +
                                 std::to_string(settings.port) +
                                 " for network.admin_port (choose another port, or 0 for any free "
                                 "one)");
}

}  // namespace

struct AdminServer::Impl {
    Impl(AdminSettings settings_in, std::vector<AdminRoute> routes, SpectatorSource source_in)
        : settings(std::move(settings_in)),
          tls(tls_context(settings)),
          router(settings.token,
                 with_description(with_spectators(std::move(routes), source_in.sample != nullptr)),
                 tls ? AdminReach::kNetwork : AdminReach::kThisMachine),
          spectators(io, router, std::move(source_in), stats.viewers),
          total_rate(settings.total_requests_per_s, 2.0 * settings.total_requests_per_s),
          accept_rate(settings.accepts_per_s, settings.accepts_per_s),
          acceptor(io),
          accept_timer(io) {
        listen();
    }

    /// A request that ends in an exception, such as for want of memory, ends nothing else.
    void run() {
        for (;;) {
            try {
                io.run();
                return;
            } catch (const std::exception&) {
                router.count("exception");
            }
        }
    }

    void listen() {
        const tcp::endpoint endpoint(listen_address(settings), settings.port);
        boost::system::error_code error;
        const auto check = [&] {
            if (error) {
                throw listen_error(error, settings);
            }
        };
        acceptor.open(endpoint.protocol(), error);
        check();
        acceptor.set_option(tcp::acceptor::reuse_address(true), error);
        check();
        acceptor.bind(endpoint, error);
        check();
        acceptor.listen(asio::socket_base::max_listen_connections, error);
        check();
        port = acceptor.local_endpoint().port();
    }

    std::vector<AdminRoute> with_spectators(std::vector<AdminRoute> routes, bool watched) {
        if (watched) {
            routes.push_back({"GET",
                              "/api/v1/spectate",
                              false,
                              [this](const AdminCall& call, const AdminReply& reply) {
                                  reply(spectators.admit(call.request));
                              },
                              {"The world as viewers draw it: a WebSocket (RFC 6455); the token is "
                               "its second protocol, after \"zoned\"",
                               nullptr,
                               nullptr,
                               {},
                               "application/octet-stream"}});
        }
        return routes;
    }

    void accept() {
        acceptor.async_accept([this](boost::system::error_code error, tcp::socket socket) {
            if (error == asio::error::operation_aborted) {
                return;
            }
            if (error) {
                router.count("accept");
                accept_after(kAcceptAgain);
                return;
            }
            if (!accept_rate.take(std::chrono::duration<double>(
                                      std::chrono::steady_clock::now().time_since_epoch())
                                      .count())) {
                admit(std::move(socket));
                accept_after(kAcceptPause);
                return;
            }
            admit(std::move(socket));
            accept();
        });
    }

    void accept_after(std::chrono::milliseconds pause) {
        accept_timer.expires_after(pause);
        accept_timer.async_wait([this](boost::system::error_code late) {
            if (!late) {
                accept();
            }
        });
    }

    void admit(tcp::socket socket) {
        ++stats.accepted;
        if (connections.size() >= 2 * settings.max_connections) {
            router.count("connections");  // not even room to say why: the socket closes here
            return;
        }
        const bool full = connections.size() >= settings.max_connections && !make_room();
        const std::uint64_t number = ++last_number;
        const auto connection = std::make_shared<HttpConnection>(
            std::move(socket),
            number,
            ConnectionContext{
                settings,
                router,
                stats,
                total_rate,
                [this](std::uint64_t gone) {
                    connections.erase(gone);
                    stats.connections = connections.size();
                },
                [this](AdminStream stream, SpectatorConnection::UpgradeRequest request) {
                    spectators.add(std::move(stream), request, ++last_number);
                },
                tls.get()});
        connections[number] = connection;
        stats.connections = connections.size();
        if (full) {
            router.count("connections");
            connection->refuse("all connections of the admin server are in use; try again");
        } else {
            connection->start();
        }
    }

    /// Closes the connection that has waited longest for a request of its client, so that idle
    /// ones cannot lock out an operator.
    bool make_room() {
        const auto waiting = std::find_if(connections.begin(),
                                          connections.end(),
                                          [](const auto& c) { return c.second->waiting(); });
        if (waiting == connections.end()) {
            return false;
        }
        router.count("evicted");
        const std::shared_ptr<HttpConnection> connection = waiting->second;
        connection->abort();
        return true;
    }

    void close() {
        boost::system::error_code ignored;
        acceptor.close(ignored);
        accept_timer.cancel();
        while (!connections.empty()) {
            const std::shared_ptr<HttpConnection> connection = connections.begin()->second;
            connection->abort();
        }
        spectators.close();
    }

    AdminSettings settings;
    std::unique_ptr<asio::ssl::context> tls;
    AdminStats stats;
    asio::io_context io{1};
    AdminRouter router;
    SpectatorService spectators;
    core::TokenBucket total_rate;
    core::TokenBucket accept_rate;
    tcp::acceptor acceptor;
    asio::steady_timer accept_timer;
    std::map<std::uint64_t, std::shared_ptr<HttpConnection>> connections;  ///< oldest first
    std::uint64_t last_number = 0;
    std::uint16_t port = 0;
    std::thread thread;
};

AdminServer::AdminServer(AdminSettings settings,
                         std::vector<AdminRoute> routes,
                         SpectatorSource source)
    : impl_(std::make_unique<Impl>(std::move(settings), std::move(routes), std::move(source))) {
}

AdminServer::~AdminServer() {
    stop();
}

void AdminServer::start() {
    impl_->accept();
    impl_->thread = std::thread([this] { impl_->run(); });
}

void AdminServer::stop() {
    if (impl_->thread.joinable()) {
        post([this] { impl_->close(); });
        impl_->thread.join();
    }
}

void AdminServer::post(std::function<void()> work) {
    asio::post(impl_->io, std::move(work));
}

std::uint16_t AdminServer::port() const {
    return impl_->port;
}

const AdminStats& AdminServer::stats() const {
    return impl_->stats;
}

const AdminRouter& AdminServer::router() const {
    return impl_->router;
}

}  // namespace zoned::admin
