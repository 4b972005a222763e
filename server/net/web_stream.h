// WebStream: a TCP socket with TLS over it or without, behind one set of calls.
#pragma once

#include <asio/ip/tcp.hpp>
#include <asio/ssl/stream.hpp>
#include <asio/write.hpp>

#include <optional>
#include <utility>

namespace zoned::net {

class WebStream {
  public:
    /// Without a context: plain.
    WebStream(asio::ip::tcp::socket socket, asio::ssl::context* context) {
        if (context != nullptr) {
            tls_.emplace(std::move(socket), *context);
        } else {
            plain_.emplace(std::move(socket));
        }
    }

    [[nodiscard]] asio::ip::tcp::socket& socket() { return tls_ ? tls_->next_layer() : *plain_; }

    [[nodiscard]] auto get_executor() { return socket().get_executor(); }

    /// nullptr: plain.
    [[nodiscard]] asio::ssl::stream<asio::ip::tcp::socket>* tls() {
        return tls_ ? &*tls_ : nullptr;
    }

    template <class Buffers, class Handler>
    void async_read_some(const Buffers& buffers, Handler handler) {
        if (tls_) {
            tls_->async_read_some(buffers, std::move(handler));
        } else {
            plain_->async_read_some(buffers, std::move(handler));
        }
    }

    template <class Buffers, class Handler>
    void async_write(const Buffers& buffers, Handler handler) {
        if (tls_) {
            asio::async_write(*tls_, buffers, std::move(handler));
        } else {
            asio::async_write(*plain_, buffers, std::move(handler));
        }
    }

  private:
    std::optional<asio::ssl::stream<asio::ip::tcp::socket>> tls_;
    std::optional<asio::ip::tcp::socket> plain_;
};

}  // namespace zoned::net
