#include "server/admin/http_connection.h"

#include <boost/asio/post.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include <chrono>
#include <utility>

namespace zoned::admin {

namespace beast = boost::beast;
namespace http = boost::beast::http;
using tcp = boost::asio::ip::tcp;

namespace {

/// After a refusal the client may still be sending: so much is read and thrown away, that it can
/// read the answer before the connection breaks.
constexpr std::size_t kLingerBytes = 1048576;
constexpr auto kLinger = std::chrono::seconds(2);

std::chrono::steady_clock::duration seconds(double s) {
    return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::chrono::duration<double>(s));
}

double now_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// Of "zoned, TOKEN".
std::string bearer_of(const std::string& protocols) {
    constexpr std::string_view kFront = "zoned, ";
    return protocols.starts_with(kFront) ? "Bearer " + protocols.substr(kFront.size()) : "";
}

std::string text_of(beast::string_view text) {
    return std::string(text.data(), text.size());
}

}  // namespace

HttpConnection::HttpConnection(tcp::socket socket, std::uint64_t number, ConnectionContext context)
    : number_(number),
      context_(std::move(context)),
      stream_(std::move(socket), context_.tls),
      answer_timer_(stream_.get_executor()),
      rate_(context_.settings.requests_per_s, 2.0 * context_.settings.requests_per_s) {
}

void HttpConnection::start() {
    shake_hands([this] { read(); });
}

void HttpConnection::refuse(const std::string& detail) {
    shake_hands([this, detail] { write(problem(503, detail)); });
}

/// `then` is called while the connection lives.
void HttpConnection::shake_hands(std::function<void()> then) {
    if (!stream_.secure()) {
        then();
        return;
    }
    waiting_ = true;
    stream_.next_layer().expires_after(seconds(context_.settings.request_timeout_s));
    stream_.async_handshake([self = shared_from_this(), then = std::move(then)](Error error) {
        self->waiting_ = false;
        if (self->closed_) {
            return;
        }
        if (error) {
            self->context_.router.count("tls_handshake");
            self->finish();
            return;
        }
        then();
    });
}

void HttpConnection::abort() {
    finish();
}

void HttpConnection::read() {
    waiting_ = true;
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(context_.settings.max_header_bytes));
    parser_->body_limit(context_.settings.max_body_bytes);
    stream_.next_layer().expires_after(seconds(context_.settings.request_timeout_s));
    http::async_read(
        stream_, buffer_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
            self->waiting_ = false;
            self->on_read(error);
        });
}

void HttpConnection::on_read(Error error) {
    if (closed_) {
        return;
    }
    if (error) {
        answer_broken(error);
        return;
    }
    keep_alive_ = parser_->get().keep_alive();
    const bool own = rate_.take(now_seconds());
    if (!own || !context_.total_rate.take(now_seconds())) {
        context_.router.count(own ? "total_flood" : "flood");
        AdminResponse response = problem(
            429,
            own ? "too many requests to the admin server" : "too many requests on this connection");
        response.headers.emplace_back("Retry-After", "1");
        keep_alive_ = false;
        write(std::move(response));
        return;
    }
    dispatch();
}

/// Bytes that are no request, or one that is too large.
void HttpConnection::answer_broken(Error error) {
    keep_alive_ = false;
    if (error == http::error::header_limit) {
        context_.router.count("header_long");
        write(problem(431,
                      "the headers are longer than " +
                          std::to_string(context_.settings.max_header_bytes) + " bytes"));
    } else if (error == http::error::body_limit) {
        context_.router.count("body_long");
        write(problem(413,
                      "the body is longer than " +
                          std::to_string(context_.settings.max_body_bytes) + " bytes"));
    } else if (error == http::error::end_of_stream) {
        finish();
    } else if (error == beast::error::timeout) {
        context_.router.count("timeout");
        finish();
    } else if (error.category() == http::make_error_code(http::error::bad_method).category() &&
               error != http::error::partial_message) {
        context_.router.count("malformed");
        write(problem(400, "this is no HTTP/1.1 request: " + error.message()));
    } else {
        context_.router.count("broken_connection");
        finish();
    }
}

void HttpConnection::dispatch() {
    auto& message = parser_->get();
    request_.method = text_of(message.method_string());
    request_.target = text_of(message.target());
    request_.host = text_of(message[http::field::host]);
    request_.origin = text_of(message[http::field::origin]);
    request_.fetch_site = text_of(message["Sec-Fetch-Site"]);
    request_.authorization = text_of(message[http::field::authorization]);
    request_.content_type = text_of(message[http::field::content_type]);
    request_.body = std::move(message.body());
    request_.upgrade = beast::websocket::is_upgrade(message);
    if (request_.upgrade) {
        // Pages cannot send an Authorization header with a WebSocket, but protocols.
        request_.authorization = bearer_of(text_of(message[http::field::sec_websocket_protocol]));
    }
    const std::uint64_t number = ++asked_;
    answer_timer_.expires_after(seconds(context_.settings.answer_timeout_s));
    answer_timer_.async_wait([weak = weak_from_this(), number](Error error) {
        const auto self = weak.lock();
        if (!error && self && self->answered_ < number) {
            self->context_.router.count("no_answer");
            self->on_answer(number, problem(504, "the server did not answer in time; try again"));
        }
    });
    context_.router.handle(request_,
                           now_seconds(),
                           [weak = weak_from_this(), executor = stream_.get_executor(), number](
                               AdminResponse response) {
                               // Replies may come from any thread, and at once: both ways they wait
                               // their turn here.
                               boost::asio::post(
                                   executor, [weak, number, moved = std::move(response)]() mutable {
                                       if (const auto self = weak.lock()) {
                                           self->on_answer(number, std::move(moved));
                                       }
                                   });
                           });
}

void HttpConnection::on_answer(std::uint64_t request, AdminResponse response) {
    if (closed_ || answered_ >= request) {
        return;
    }
    answered_ = request;
    answer_timer_.cancel();
    if (response.status == 101) {
        upgrade();
    } else {
        // Whoever asked for a WebSocket and got none has nothing more to ask here.
        keep_alive_ = keep_alive_ && !request_.upgrade;
        write(std::move(response));
    }
}

void HttpConnection::upgrade() {
    ++context_.stats.answers[101];
    closed_ = true;
    const auto self = shared_from_this();
    context_.closed(number_);
    context_.upgraded(std::move(stream_), parser_->release());
}

void HttpConnection::write(AdminResponse response) {
    ++context_.stats.answers[response.status];
    context_.stats.bytes_out += response.body.size();
    response_ = {};
    response_.version(11);
    response_.result(response.status);
    response_.reason(status_phrase(response.status));
    response_.set(http::field::content_type, response.content_type);
    response_.set(http::field::cache_control, "no-store");
    response_.set("X-Content-Type-Options", "nosniff");
    for (const auto& [name, value] : response.headers) {
        response_.set(name, value);
    }
    response_.keep_alive(keep_alive_);
    response_.body() = std::move(response.body);
    response_.prepare_payload();
    stream_.next_layer().expires_after(seconds(context_.settings.write_timeout_s));
    http::async_write(stream_, response_, [self = shared_from_this()](Error error, std::size_t) {
        self->on_write(error);
    });
}

void HttpConnection::on_write(Error error) {
    if (closed_) {
        return;
    }
    if (error) {
        context_.router.count(error == beast::error::timeout ? "slow_reader" : "broken_connection");
        finish();
    } else if (keep_alive_) {
        read();
    } else {
        Error ignored;
        stream_.next_layer().socket().shutdown(tcp::socket::shutdown_send, ignored);
        stream_.next_layer().expires_after(kLinger);
        waiting_ = true;
        linger();
    }
}

void HttpConnection::linger() {
    buffer_.clear();
    stream_.async_read_some(
        buffer_.prepare(4096), [self = shared_from_this()](Error error, std::size_t bytes) {
            self->lingered_bytes_ += bytes;
            if (error || self->closed_ || self->lingered_bytes_ > kLingerBytes) {
                self->finish();
            } else {
                self->linger();
            }
        });
}

void HttpConnection::finish() {
    if (closed_) {
        return;
    }
    closed_ = true;
    answer_timer_.cancel();
    stream_.next_layer().close();
    context_.closed(number_);
}

}  // namespace zoned::admin
