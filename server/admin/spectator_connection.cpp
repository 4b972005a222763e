#include "server/admin/spectator_connection.h"

#include <boost/beast/http/field.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <utility>

namespace zoned::admin {

namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using Error = boost::beast::error_code;

namespace {

/// A viewer says what it looks at, and answers pings.
constexpr std::size_t kMostBytesFromViewer = 1024;

}  // namespace

SpectatorConnection::SpectatorConnection(AdminStream stream,
                                         std::uint64_t number,
                                         AdminRouter& router,
                                         std::function<void(std::uint64_t)> closed)
    : number_(number),
      router_(router),
      closed_callback_(std::move(closed)),
      socket_(std::move(stream)) {
}

void SpectatorConnection::accept(const UpgradeRequest& request, std::string scene) {
    beast::get_lowest_layer(socket_).expires_never();
    websocket::stream_base::timeout timeout{};
    timeout.handshake_timeout = std::chrono::seconds(10);
    timeout.idle_timeout = std::chrono::seconds(20);
    timeout.keep_alive_pings = true;
    socket_.set_option(timeout);
    socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
        response.set(beast::http::field::sec_websocket_protocol, "zoned");
    }));
    socket_.auto_fragment(false);
    socket_.read_message_max(kMostBytesFromViewer);
    socket_.async_accept(
        request, [self = shared_from_this(), moved = std::move(scene)](Error error) mutable {
            if (error || self->closed_) {
                self->finish();
                return;
            }
            self->open_ = true;
            self->push({std::make_shared<const std::string>(std::move(moved)), true});
            self->read();
        });
}

void SpectatorConnection::send(const SpectatorMessage& change,
                               const std::function<SpectatorMessage()>& everything) {
    if (!open_ || closed_) {
        return;
    }
    if (queue_.size() >= kMostQueuedMessages) {
        if (!needs_everything_) {
            router_.count("slow_viewer");
        }
        needs_everything_ = true;
    } else if (needs_everything_) {
        // Only an empty queue takes the large message: a slow viewer gets it as seldom as it can.
        if (queue_.empty()) {
            needs_everything_ = false;
            push({everything(), false});
        }
    } else if (change) {
        push({change, false});
    }
}

void SpectatorConnection::send_layer(SpectatorLayer layer, const SpectatorMessage& message) {
    if (open_ && !closed_ && (wish_.layers & layer) != 0 && !needs_everything_ &&
        queue_.size() < kMostQueuedMessages) {
        push({message, false});
    }
}

void SpectatorConnection::abort() {
    finish();
}

void SpectatorConnection::read() {
    socket_.async_read(buffer_, [self = shared_from_this()](Error error, std::size_t) {
        if (error || self->closed_) {
            self->finish();
            return;
        }
        self->on_wish();
        self->buffer_.clear();
        self->read();
    });
}

void SpectatorConnection::on_wish() {
    SpectatorWish wish;
    if (socket_.got_text() || buffer_.size() != sizeof(wish.layers) + sizeof(wish.eye)) {
        router_.count("bad_wish");
        return;
    }
    const auto* bytes = static_cast<const char*>(buffer_.data().data());
    std::memcpy(&wish.layers, bytes, sizeof(wish.layers));
    std::memcpy(wish.eye.data(), bytes + sizeof(wish.layers), sizeof(wish.eye));
    if (!std::all_of(wish.eye.begin(), wish.eye.end(), [](float v) { return std::isfinite(v); })) {
        router_.count("bad_wish");
        return;
    }
    wish_ = wish;
    has_wish_ = true;
}

void SpectatorConnection::push(Queued message) {
    queue_.push_back(std::move(message));
    if (queue_.size() == 1) {
        write();
    }
}

void SpectatorConnection::write() {
    socket_.text(queue_.front().text);
    socket_.async_write(boost::asio::buffer(*queue_.front().bytes),
                        [self = shared_from_this()](Error error, std::size_t) {
                            if (error || self->closed_) {
                                self->finish();
                                return;
                            }
                            self->queue_.pop_front();
                            if (!self->queue_.empty()) {
                                self->write();
                            }
                        });
}

void SpectatorConnection::finish() {
    if (closed_) {
        return;
    }
    closed_ = true;
    beast::get_lowest_layer(socket_).close();
    closed_callback_(number_);
}

}  // namespace zoned::admin
