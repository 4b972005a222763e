#include "server/net/handshake_queue.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace zoned::net {

namespace {

constexpr std::size_t kRecordHead = 5;
constexpr std::size_t kLongestRecord = 16384;
constexpr std::uint8_t kHandshakeRecord = 22;  ///< RFC 8446, section 5.1
constexpr std::uint8_t kMajorVersion = 3;

/// The first bytes of a connection, still unread.
struct Seen {
    std::array<std::uint8_t, kRecordHead> head{};
    std::size_t bytes = 0;  ///< of the head
    bool ended = false;     ///< nothing more will come
};

Seen peek(int fd) {
    Seen seen;
    const ssize_t got = ::recv(fd, seen.head.data(), seen.head.size(), MSG_PEEK | MSG_DONTWAIT);
    seen.bytes = got > 0 ? static_cast<std::size_t>(got) : 0;
    pollfd watch{fd, POLLRDHUP, 0};
    seen.ended = got == 0 || (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK) ||
                 (::poll(&watch, 1, 0) == 1 && watch.revents != 0);
    return seen;
}

bool begins_tls(const Seen& seen) {
    const std::size_t length = (std::size_t{seen.head[3]} << 8U) | seen.head[4];
    return (seen.bytes < 1 || seen.head[0] == kHandshakeRecord) &&
           (seen.bytes < 2 || seen.head[1] == kMajorVersion) &&
           (seen.bytes < kRecordHead || (length > 0 && length <= kLongestRecord));
}

/// Bytes of the first record, as far as they are known.
std::size_t wanted_of(const Seen& seen) {
    return seen.bytes < kRecordHead
               ? kRecordHead
               : kRecordHead + ((std::size_t{seen.head[3]} << 8U) | seen.head[4]);
}

/// The socket wakes its waiter once this much is there, or the end.
void wake_at(asio::ip::tcp::socket& socket, std::size_t bytes) {
    asio::error_code ignored;
    socket.set_option(asio::socket_base::receive_low_watermark(static_cast<int>(bytes)), ignored);
}

}  // namespace

HandshakeQueue::HandshakeQueue(asio::io_context& io,
                               const HandshakeQueueSettings& settings,
                               Callbacks callbacks)
    : settings_(settings),
      callbacks_(std::move(callbacks)),
      sweep_timer_(io),
      turn_timer_(io) {
}

void HandshakeQueue::add(asio::ip::tcp::socket socket, const Address& peer) {
    const Number number = ++last_;
    waiting_.emplace(number, Waiting{std::move(socket), peer, Clock::now()});
    if (waiting_.size() == 1) {
        arm_sweep();
    }
    look(number);
}

void HandshakeQueue::clear() {
    callbacks_ = {};
    waiting_.clear();
    ready_.clear();
    ready_count_ = 0;
    turns_.clear();
    sweep_timer_.cancel();
    turn_timer_.cancel();
}

void HandshakeQueue::wait_for_bytes(Number number) {
    waiting_.at(number).socket.async_wait(
        asio::ip::tcp::socket::wait_read,
        [self = shared_from_this(), number](const asio::error_code& ec) {
            if (!ec && self->waiting_.contains(number)) {
                self->look(number);
            }
        });
}

void HandshakeQueue::look(Number number) {
    Waiting& one = waiting_.at(number);
    const Seen seen = peek(one.socket.native_handle());
    if (settings_.tls && !begins_tls(seen)) {
        leave(number, Left::kNoTls);
        return;
    }
    const std::size_t wanted = settings_.tls ? wanted_of(seen) : 1;
    // More may have come since: only a record whose length was seen can be known to be whole.
    const bool known = settings_.tls ? seen.bytes == kRecordHead : seen.bytes > 0;
    asio::error_code ec;
    if (known && one.socket.available(ec) >= wanted && !ec) {
        be_ready(number);
    } else if (seen.ended || ec) {
        leave(number, Left::kClosed);
    } else {
        wake_at(one.socket, seen.bytes == 0 ? 1 : wanted);
        wait_for_bytes(number);
    }
}

void HandshakeQueue::be_ready(Number number) {
    auto one = waiting_.extract(number);
    one.mapped().spent = Clock::now() - one.mapped().since;
    const NetworkKey network = network_of(one.mapped().peer);
    std::deque<Waiting>& line = ready_[network];
    if (line.empty()) {
        turns_.push_back(network);
    }
    line.push_back(std::move(one.mapped()));
    ++ready_count_;
    start_those_due();
}

void HandshakeQueue::leave(Number number, Left why) {
    const Address peer = waiting_.at(number).peer;
    waiting_.erase(number);
    callbacks_.left(peer, why);
}

// ---------------------------------------------------------------- too late

HandshakeQueue::Clock::duration HandshakeQueue::patience() const {
    return std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(settings_.timeout_s));
}

/// All wait equally long for their message, so the first to come is the first to go.
void HandshakeQueue::arm_sweep() {
    if (waiting_.empty()) {
        return;
    }
    sweep_timer_.expires_at(waiting_.begin()->second.since + patience());
    sweep_timer_.async_wait([self = shared_from_this()](const asio::error_code& ec) {
        if (!ec) {
            self->sweep();
        }
    });
}

void HandshakeQueue::sweep() {
    const Clock::time_point now = Clock::now();
    while (!waiting_.empty() && waiting_.begin()->second.since + patience() <= now) {
        leave(waiting_.begin()->first, Left::kTimeout);
    }
    arm_sweep();
}

// ---------------------------------------------------------------- turns

HandshakeQueue::Clock::duration HandshakeQueue::turn_wait() {
    const Clock::time_point now = Clock::now();
    next_start_ = std::max(next_start_, now - std::chrono::seconds(1));
    return std::max(next_start_ - now, Clock::duration::zero());
}

void HandshakeQueue::start_those_due() {
    while (!turns_.empty()) {
        if (const Clock::duration wait = turn_wait(); wait > Clock::duration::zero()) {
            turn_timer_.expires_after(wait);
            turn_timer_.async_wait([self = shared_from_this()](const asio::error_code& ec) {
                if (!ec) {
                    self->start_those_due();
                }
            });
            return;
        }
        const NetworkKey network = turns_.front();
        turns_.pop_front();
        const auto line = ready_.find(network);
        Waiting one = std::move(line->second.front());
        line->second.pop_front();
        --ready_count_;
        if (line->second.empty()) {
            ready_.erase(line);
        } else {
            turns_.push_back(network);
        }
        if (peek(one.socket.native_handle()).ended) {
            callbacks_.left(one.peer, Left::kClosed);
            continue;
        }
        wake_at(one.socket, 1);
        next_start_ += std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(1.0 / settings_.starts_per_s));
        callbacks_.start(std::move(one.socket), one.peer, one.spent);
    }
}

}  // namespace zoned::net
