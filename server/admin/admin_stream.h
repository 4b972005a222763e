// AdminStream: a client's connection to the admin server, plain on loopback, TLS elsewhere.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>

#include <memory>
#include <optional>
#include <utility>

namespace zoned::admin {

/// Beast's AsyncStream: which of both it is, is known at run time, so that everything above it is
/// compiled once. Timeouts are those of next_layer().
class AdminStream {
  public:
    using next_layer_type = boost::beast::tcp_stream;
    using executor_type = next_layer_type::executor_type;

    /// Without a context the stream is plain; a context must outlive it.
    AdminStream(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context* context)
        : inner_(std::make_unique<Inner>(std::move(socket))) {
        if (context != nullptr) {
            inner_->tls.emplace(inner_->tcp, *context);
        }
    }

    [[nodiscard]] bool secure() const { return inner_->tls.has_value(); }

    executor_type get_executor() { return inner_->tcp.get_executor(); }

    next_layer_type& next_layer() { return inner_->tcp; }

    [[nodiscard]] const next_layer_type& next_layer() const { return inner_->tcp; }

    /// Only where the stream is secure.
    template <class Handler>
    void async_handshake(Handler&& handler) {
        inner_->tls->async_handshake(boost::asio::ssl::stream_base::server,
                                     std::forward<Handler>(handler));
    }

    template <class Buffers, class Handler>
    void async_read_some(const Buffers& buffers, Handler&& handler) {
        if (inner_->tls) {
            inner_->tls->async_read_some(buffers, std::forward<Handler>(handler));
        } else {
            inner_->tcp.async_read_some(buffers, std::forward<Handler>(handler));
        }
    }

    template <class Buffers, class Handler>
    void async_write_some(const Buffers& buffers, Handler&& handler) {
        if (inner_->tls) {
            inner_->tls->async_write_some(buffers, std::forward<Handler>(handler));
        } else {
            inner_->tcp.async_write_some(buffers, std::forward<Handler>(handler));
        }
    }

  private:
    /// TLS refers to the connection below: neither moves.
    struct Inner {
        explicit Inner(boost::asio::ip::tcp::socket socket) : tcp(std::move(socket)) {}

        boost::beast::tcp_stream tcp;
        std::optional<boost::asio::ssl::stream<boost::beast::tcp_stream&>> tls;
    };

    std::unique_ptr<Inner> inner_;
};

/// The end of a WebSocket is that of its connection.
inline void teardown(boost::beast::role_type role,
                     AdminStream& stream,
                     boost::beast::error_code& error) {
    boost::beast::websocket::teardown(role, stream.next_layer().socket(), error);
}

template <class Handler>
void async_teardown(boost::beast::role_type role, AdminStream& stream, Handler&& handler) {
    boost::beast::websocket::async_teardown(
        role, stream.next_layer().socket(), std::forward<Handler>(handler));
}

}  // namespace zoned::admin
