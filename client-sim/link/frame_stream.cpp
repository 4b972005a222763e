#include "client-sim/link/frame_stream.h"

#include <utility>

namespace zoned::link {

namespace {

/// A server that sends without end does not hold up a frame of the game for it.
constexpr std::size_t kMostBytesAtOnce = std::size_t{4} << 20U;

}  // namespace

SocketStream::SocketStream(const StreamWorld& world,
                           Trust trust,
                           StreamEvents events,
                           bool plain_at_home)
    : trust_(std::move(trust)),
      events_(std::move(events)),
      world_(world),
      plain_at_home_(plain_at_home) {
}

SocketStream::~SocketStream() {
    if (number_ >= 0) {
        world_.sockets.close(number_);
    }
}

void SocketStream::connect(const std::string& host, std::uint16_t port) {
    number_ = world_.sockets.open(host, port);
}

std::string SocketStream::trouble() const {
    return tls_ ? tls_->trouble() : world_.sockets.trouble(number_);
}

void SocketStream::advance() {
    if (dead_ || number_ < 0 || (!world_.sockets.is_ready(number_) && pending_.empty())) {
        return;
    }
    if (!open_) {
        open();
    }
    if (open_ && !dead_) {
        read();
        write();
    }
}

void SocketStream::open() {
    const StreamState state = world_.sockets.state(number_);
    if (state == StreamState::kLost) {
        fail("cannot connect: " + world_.sockets.trouble(number_));
        return;
    }
    if (state == StreamState::kOpening) {
        return;
    }
    if (!shaking_) {
        shaking_ = true;
        if (!plain_at_home_ || !world_.sockets.is_local(number_)) {
            tls_.emplace(world_.tls, trust_, world_.sockets, number_);
        }
    }
    if (tls_) {
        const TlsResult result = tls_->shake_hands();
        if (result == TlsResult::kFailed) {
            fail("TLS handshake failed: " + tls_->trouble());
        }
        if (result != TlsResult::kDone) {
            return;
        }
    }
    open_ = true;
    on_open();
}

TlsResult SocketStream::plain_result(std::ptrdiff_t done, std::size_t& size) {
    if (done > 0) {
        size = static_cast<std::size_t>(done);
        return TlsResult::kDone;
    }
    if (done == Sockets::kEnded) {
        return TlsResult::kEnded;
    }
    return done == 0 ? TlsResult::kWaits : TlsResult::kFailed;
}

TlsResult SocketStream::receive(std::span<std::uint8_t> into, std::size_t& size) {
    return tls_ ? tls_->read(into, size)
                : plain_result(world_.sockets.receive(number_, into), size);
}

TlsResult SocketStream::send(std::span<const std::uint8_t> bytes, std::size_t& size) {
    return tls_ ? tls_->write(bytes, size)
                : plain_result(world_.sockets.send(number_, bytes), size);
}

void SocketStream::read() {
    for (std::size_t taken = 0; !dead_ && taken < kMostBytesAtOnce;) {
        std::size_t size = 0;
        const TlsResult result = receive(room(), size);
        if (result == TlsResult::kWaits) {
            return;
        }
        if (result != TlsResult::kDone) {
            fail(result == TlsResult::kEnded ? std::string() : "stream failed: " + trouble());
            return;
        }
        taken += size;
        if (!closing_) {
            on_bytes(size);
        }
    }
}

void SocketStream::write() {
    if (!open_ || dead_) {
        return;
    }
    std::size_t sent = 0;
    while (sent < pending_.size()) {
        std::size_t size = 0;
        const TlsResult result = send(std::span(pending_).subspan(sent), size);
        if (result == TlsResult::kWaits) {
            break;
        }
        if (result != TlsResult::kDone) {
            fail("stream failed: " + trouble());
            return;
        }
        sent += size;
    }
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(sent));
    if (closing_ && pending_.empty()) {
        finish();
    }
}

void SocketStream::close() {
    if (dead_ || closing_) {
        return;
    }
    closing_ = true;
    events_ = {};
    if (!open_) {
        fail({});
        return;
    }
    say_goodbye();
    write();
}

/// All is said. A stream that is closed before it is read to its end is reset, and the server might
/// miss the last words: it ends when the server ends it.
void SocketStream::finish() {
    if (std::exchange(shut_, true)) {
        return;
    }
    if (tls_) {
        tls_->shut_down();
    }
}

void SocketStream::fail(const std::string& reason) {
    if (dead_) {
        return;
    }
    dead_ = true;
    tls_.reset();
    if (number_ >= 0) {
        world_.sockets.close(std::exchange(number_, -1));
    }
    // Moved out first: the listener may close or reopen from within the call.
    const auto closed = std::move(events_.closed);
    events_ = {};
    if (closed) {
        closed(reason);
    }
}

}  // namespace zoned::link
