// AdminStream: a client's connection to the admin server, plain on loopback, TLS elsewhere.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/buffers_range.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
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
        start_read(first_of(buffers), erased(std::forward<Handler>(handler)));
    }

    template <class Buffers, class Handler>
    void async_write_some(const Buffers& buffers, Handler&& handler) {
        start_write(gathered(buffers), erased(std::forward<Handler>(handler)));
    }

  private:
    /// One type for all that waits: the connection below and TLS are compiled once, not once for
    /// each operation of HTTP and WebSockets.
    using Waiting = std::function<void(boost::beast::error_code, std::size_t)>;
    using Gathered = std::array<boost::asio::const_buffer, 16>;

    template <class Handler>
    static Waiting erased(Handler&& handler) {
        auto held = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
        return [held](boost::beast::error_code error, std::size_t bytes) {
            auto& waiting = *held;
            std::move(waiting)(error, bytes);
        };
    }

    /// A read of some bytes may take fewer than there is room for.
    template <class Buffers>
    static boost::asio::mutable_buffer first_of(const Buffers& buffers) {
        for (const boost::asio::mutable_buffer buffer : boost::beast::buffers_range_ref(buffers)) {
            if (buffer.size() > 0) {
                return buffer;
            }
        }
        return {};
    }

    /// So may a write.
    template <class Buffers>
    static Gathered gathered(const Buffers& buffers) {
        Gathered out;
        std::size_t count = 0;
        for (const boost::asio::const_buffer buffer : boost::beast::buffers_range_ref(buffers)) {
            if (buffer.size() > 0 && count < out.size()) {
                out[count++] = buffer;
            }
        }
        return out;
    }

    void start_read(boost::asio::mutable_buffer buffer, Waiting waiting);
    void start_write(const Gathered& buffers, Waiting waiting);

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
