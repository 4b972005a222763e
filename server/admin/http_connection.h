// HttpConnection: one client of the admin server, a request at a time.
#pragma once

#include "server/admin/admin_server.h"
#include "server/admin/admin_stream.h"

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

namespace zoned::admin {

/// What a connection shares with its server.
struct ConnectionContext {
    const AdminSettings& settings;
    AdminRouter& router;
    AdminStats& stats;
    core::TokenBucket& total_rate;  ///< of all connections
    std::function<void(std::uint64_t number)> closed;
    /// Takes over a connection that is to become a WebSocket.
    std::function<void(AdminStream, boost::beast::http::request<boost::beast::http::string_body>)>
        upgraded;
    boost::asio::ssl::context* tls = nullptr;  ///< null: plain
};

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
  public:
    HttpConnection(boost::asio::ip::tcp::socket socket,
                   std::uint64_t number,
                   ConnectionContext context);

    void start();
    /// Answers with a problem and closes: there is no room for this connection.
    void refuse(const std::string& detail);
    /// Closes at once.
    void abort();

    /// Waits for a request, so that nothing is lost when it is closed.
    [[nodiscard]] bool waiting() const { return waiting_; }

  private:
    using Error = boost::beast::error_code;

    void shake_hands(std::function<void()> then);
    void read();
    void on_read(Error error);
    void answer_broken(Error error);
    void dispatch();
    void on_answer(std::uint64_t request, AdminResponse response);
    void upgrade();
    void write(AdminResponse response);
    void on_write(Error error);
    void linger();
    void finish();

    std::uint64_t number_;
    ConnectionContext context_;
    AdminStream stream_;
    boost::beast::flat_buffer buffer_;
    std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
    boost::beast::http::response<boost::beast::http::string_body> response_;
    boost::asio::steady_timer answer_timer_;
    core::TokenBucket rate_;
    AdminRequest request_;
    std::uint64_t asked_ = 0;     ///< requests so far
    std::uint64_t answered_ = 0;  ///< and answers: a second answer to a request is dropped
    std::size_t lingered_bytes_ = 0;
    bool waiting_ = false;
    bool closed_ = false;
    bool keep_alive_ = false;
};

}  // namespace zoned::admin
