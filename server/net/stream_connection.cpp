#include "server/net/stream_connection.h"

#include <asio/post.hpp>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace zoned::net {

namespace {

constexpr std::size_t kPrefixBytes = 4;
constexpr std::size_t kFirstBuffer = 2048;
/// A buffer that grew beyond this for once (a login's world, say) is given back: there are
/// thousands of connections.
constexpr std::size_t kKeptBuffer = 16384;

/// So much of a tail is handed to TLS at a time.
constexpr std::size_t kTailSlice = 65536;

/// Bytes of a WebSocket that the kernel takes before the path does.
constexpr int kKernelQueue = 4096;

/// Pings of a WebSocket's client; many more are a flood.
constexpr double kControlFramesPerSecond = 5.0;
constexpr std::uint16_t kNormalEnd = 1000;

struct RefusalCounter {
    const char* reason;
    std::uint64_t TlsStats::*count;
};

constexpr std::array<RefusalCounter, 6> kRefusals{{
    {"connections_address", &TlsStats::refused_address},
    {"connections_all", &TlsStats::refused_total},
    {"frame_oversize", &TlsStats::frame_oversize},
    {"handshake_failed", &TlsStats::handshake_failed},
    {"handshake_timeout", &TlsStats::handshake_timeout},
    {"stream_backlog", &TlsStats::queue_overflow},
}};

std::size_t read_prefix(const std::uint8_t* p) {
    return static_cast<std::size_t>(p[0]) | (static_cast<std::size_t>(p[1]) << 8) |
           (static_cast<std::size_t>(p[2]) << 16) | (static_cast<std::size_t>(p[3]) << 24);
}

}  // namespace

void add_refusals(const TlsStats& stats, std::map<std::string, std::uint64_t>& counts) {
    for (const RefusalCounter& refusal : kRefusals) {
        if (stats.*refusal.count != 0) {
            counts[refusal.reason] += stats.*refusal.count;
        }
    }
}

std::vector<std::string> refusal_reasons() {
    std::vector<std::string> out;
    for (const RefusalCounter& refusal : kRefusals) {
        out.emplace_back(refusal.reason);
    }
    return out;
}

StreamConnection::StreamConnection(asio::ip::tcp::socket socket,
                                   asio::ssl::context* context,
                                   std::shared_ptr<const WebSocketGate> gate,
                                   StreamNumber number,
                                   const Address& peer,
                                   const ConnectionLimits& limits,
                                   Clock::duration spent,
                                   std::shared_ptr<ConnectionEvents> events)
    : stream_(std::move(socket), context),
      gate_(std::move(gate)),
      control_frames_(kControlFramesPerSecond, 4.0 * kControlFramesPerSecond),
      deadline_(stream_.get_executor()),
      number_(number),
      peer_(peer),
      limits_(limits),
      since_(Clock::now() - spent),
      events_(std::move(events)),
      in_(kFirstBuffer) {
}

void StreamConnection::start() {
    asio::error_code ignored;
    stream_.socket().set_option(asio::ip::tcp::no_delay(true), ignored);
    if (gate_) {
        // States travel in it: what the path cannot take yet waits here, where it is counted, and
        // not in the kernel.
        const int most = kKernelQueue;
        setsockopt(
            stream_.socket().native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &most, sizeof(most));
    }
    arm_deadline(std::max(0.0, limits_.handshake_timeout_s - spent_s()));
    if (stream_.tls() == nullptr) {
        read_upgrade();
        return;
    }
    stream_.tls()->async_handshake(
        asio::ssl::stream_base::server,
        [self = shared_from_this()](const asio::error_code& ec) { self->on_handshake(ec); });
}

void StreamConnection::on_handshake(const asio::error_code& ec) {
    if (state_ == ConnectionState::kDone) {
        return;
    }
    if (gate_ && !ec) {
        read_upgrade();
        return;
    }
    if (ec) {
        ++events_->stats.handshake_failed;
        finish("the TLS handshake failed");
        return;
    }
    open();
    if (state_ == ConnectionState::kOpen) {
        read();
    }
}

void StreamConnection::open() {
    deadline_.cancel();
    state_ = ConnectionState::kOpen;
    opened_ = true;
    ++events_->stats.opened;
    if (events_->opened) {
        events_->opened(*this);
    }
}

// ---------------------------------------------------------------- reading

void StreamConnection::read() {
    if (filled_ == in_.size()) {
        // Grows with the bytes that arrived, not with the claim of a prefix.
        in_.resize(std::min(2 * in_.size(), kPrefixBytes + limits_.max_frame_bytes));
    }
    reading_ = true;
    stream_.async_read_some(
        asio::buffer(in_.data() + filled_, in_.size() - filled_),
        [self = shared_from_this()](const asio::error_code& ec, std::size_t bytes) {
            self->on_read(ec, bytes);
        });
}

void StreamConnection::on_read(const asio::error_code& ec, std::size_t bytes) {
    reading_ = false;
    if (state_ == ConnectionState::kDone) {
        return;
    }
    if (state_ == ConnectionState::kClosing) {
        if (!write_in_progress_) {
            shut_down();
        }
        return;
    }
    if (ec == asio::error::eof) {
        close();  // the peer ended in order: answer in order
        return;
    }
    if (ec) {
        finish("the connection was lost: " + ec.message());
        return;
    }
    events_->stats.bytes_in += bytes;
    filled_ += bytes;
    if (gate_ ? take_messages() : take_frames()) {
        read();
    }
}

bool StreamConnection::take_frames() {
    std::size_t at = 0;
    while (filled_ - at >= kPrefixBytes) {
        const std::size_t length = read_prefix(in_.data() + at);
        if (length > limits_.max_frame_bytes) {
            ++events_->stats.frame_oversize;
            finish("a frame of " + std::to_string(length) + " bytes was announced; at most " +
                   std::to_string(limits_.max_frame_bytes) + " are taken");
            return false;
        }
        if (filled_ - at - kPrefixBytes < length) {
            break;
        }
        if (events_->frame) {
            events_->frame(*this, {in_.data() + at + kPrefixBytes, length});
        }
        if (state_ != ConnectionState::kOpen) {
            return false;
        }
        at += kPrefixBytes + length;
    }
    std::copy(in_.begin() + static_cast<std::ptrdiff_t>(at),
              in_.begin() + static_cast<std::ptrdiff_t>(filled_),
              in_.begin());
    filled_ -= at;
    if (filled_ == 0 && in_.size() > kKeptBuffer) {
        in_ = std::vector<std::uint8_t>(kFirstBuffer);
    }
    return true;
}

// ---------------------------------------------------------------- writing

void StreamConnection::send(std::span<const std::uint8_t> frame, SharedBytes tail) {
    if (state_ != ConnectionState::kOpen) {
        return;
    }
    if (queued_ + writing_.size() + kPrefixBytes + frame.size() > limits_.max_queue_bytes) {
        ++events_->stats.queue_overflow;
        finish("the client is too slow: more than " + std::to_string(limits_.max_queue_bytes) +
               " bytes wait to be sent");
        return;
    }
    const std::size_t tail_bytes = tail ? tail->size() : 0;
    if (pending_.empty() || pending_.back().tail) {
        pending_.emplace_back();
    }
    std::vector<std::uint8_t>& own = pending_.back().own;
    const std::size_t before = own.size();
    append_prefix(own, frame.size() + tail_bytes);
    own.insert(own.end(), frame.begin(), frame.end());
    queued_ += own.size() - before;
    shared_ += tail_bytes;
    pending_.back().tail = std::move(tail);
    start_writing();
}

void StreamConnection::append_prefix(std::vector<std::uint8_t>& out, std::uint64_t length) const {
    if (gate_) {
        std::array<std::uint8_t, wire::kMaxWebSocketHead> head{};
        const std::size_t size =
            wire::write_websocket_head(wire::WebSocketOpcode::kBinary, length, head);
        out.insert(out.end(), head.begin(), head.begin() + static_cast<std::ptrdiff_t>(size));
        return;
    }
    for (int shift = 0; shift < 32; shift += 8) {
        out.push_back(static_cast<std::uint8_t>(length >> shift));
    }
}

void StreamConnection::start_writing() {
    if (!write_in_progress_) {
        // After the caller's turn, so that all its frames share a TLS record and a system call.
        write_in_progress_ = true;
        asio::post(stream_.get_executor(), [self = shared_from_this()] { self->write(); });
    }
}

void StreamConnection::write() {
    if (state_ == ConnectionState::kDone) {
        return;
    }
    QueuedFrames& front = pending_.front();
    writing_.clear();
    writing_.swap(front.own);
    queued_ -= writing_.size();
    tail_ = std::move(front.tail);
    tail_sent_ = 0;
    if (tail_ || pending_.size() > 1) {
        pending_.pop_front();
    }
    stream_.async_write(asio::buffer(writing_),
                        [self = shared_from_this()](const asio::error_code& ec, std::size_t bytes) {
                            self->on_written(ec, bytes);
                        });
}

void StreamConnection::write_slice() {
    const std::size_t bytes = std::min(kTailSlice, tail_->size() - tail_sent_);
    stream_.async_write(asio::buffer(tail_->data() + tail_sent_, bytes),
                        [self = shared_from_this()](const asio::error_code& ec, std::size_t sent) {
                            self->tail_sent_ += sent;
                            self->shared_ -= sent;
                            self->on_written(ec, sent);
                        });
}

void StreamConnection::on_written(const asio::error_code& ec, std::size_t bytes) {
    if (state_ == ConnectionState::kDone) {
        return;
    }
    if (ec) {
        finish("the connection was lost: " + ec.message());
        return;
    }
    events_->stats.bytes_out += bytes;
    writing_.clear();
    if (tail_ && tail_sent_ < tail_->size()) {
        write_slice();
        return;
    }
    tail_ = nullptr;
    if (queued_ > 0) {
        write();
        return;
    }
    write_in_progress_ = false;
    pending_.clear();
    if (writing_.capacity() > kKeptBuffer) {
        writing_ = std::vector<std::uint8_t>();
    }
    if (state_ == ConnectionState::kClosing) {
        shut_down();
    }
}

// ---------------------------------------------------------------- ending

void StreamConnection::close() {
    if (state_ == ConnectionState::kHandshake) {
        finish("closed during the handshake");
        return;
    }
    if (state_ != ConnectionState::kOpen) {
        return;
    }
    if (gate_ && !std::exchange(close_sent_, true)) {
        const std::array<std::uint8_t, 2> code = {kNormalEnd >> 8U, kNormalEnd & 0xFFU};
        append_control(wire::WebSocketOpcode::kClose, code);
    }
    state_ = ConnectionState::kClosing;
    arm_deadline(limits_.close_timeout_s);
    if (!write_in_progress_) {
        shut_down();
    }
}

void StreamConnection::abort(const std::string& reason) {
    finish(reason);
}

/// Sends close_notify. No other operation may be pending on the TLS stream, so a read is cancelled
/// first and its handler comes back here.
void StreamConnection::shut_down() {
    if (reading_) {
        asio::error_code ignored;
        stream_.socket().cancel(ignored);
        return;
    }
    if (std::exchange(shutting_down_, true)) {
        return;
    }
    if (stream_.tls() == nullptr) {
        linger();
        return;
    }
    stream_.tls()->async_shutdown([self = shared_from_this()](const asio::error_code& ec) {
        if (self->state_ == ConnectionState::kDone) {
            return;
        }
        if (!ec) {
            self->finish("");
        } else {
            self->linger();
        }
    });
}

/// The peer was still sending. Closing now would reset the connection and could destroy our last
/// frames in flight. So incoming data is read and dropped until the peer has ended.
void StreamConnection::linger() {
    asio::error_code ec;
    stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ec);
    if (ec) {
        finish("");
        return;
    }
    discard();
}

void StreamConnection::discard() {
    stream_.socket().async_read_some(
        asio::buffer(in_), [self = shared_from_this()](const asio::error_code& ec, std::size_t) {
            if (self->state_ == ConnectionState::kDone) {
                return;
            }
            if (ec) {
                self->finish("");
            } else {
                self->discard();
            }
        });
}

void StreamConnection::arm_deadline(double seconds) {
    deadline_.expires_after(std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::duration<double>(seconds)));
    deadline_.async_wait([self = shared_from_this()](const asio::error_code& ec) {
        if (ec || self->state_ == ConnectionState::kOpen ||
            self->state_ == ConnectionState::kDone) {
            return;
        }
        if (self->state_ == ConnectionState::kHandshake) {
            ++self->events_->stats.handshake_timeout;
            self->finish("the handshake took too long");
        } else {
            ++self->events_->stats.close_timeout;
            self->finish("the peer did not end the connection in time");
        }
    });
}

void StreamConnection::finish(const std::string& reason) {
    if (std::exchange(state_, ConnectionState::kDone) == ConnectionState::kDone) {
        return;
    }
    deadline_.cancel();
    asio::error_code ignored;
    stream_.socket().close(ignored);
    asio::post(stream_.get_executor(), [self = shared_from_this(), reason] {
        if (self->events_->closed) {
            self->events_->closed(*self, reason);
        }
    });
}

}  // namespace zoned::net
