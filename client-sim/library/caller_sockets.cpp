#include "client-sim/library/caller_sockets.h"

#include <utility>

namespace zoned::library {

namespace {

/// Larger than any datagram of the protocol: a longer one is cut, and does not authenticate.
constexpr std::size_t kDatagramBytes = 2048;

/// A function of the caller that returns more than it was given room for must not harm us.
std::ptrdiff_t checked(std::ptrdiff_t returned, std::size_t most) {
    if (returned == ZONED_CLIENT_SOCKET_ENDED) {
        return link::Sockets::kEnded;
    }
    return returned >= 0 && static_cast<std::size_t>(returned) <= most ? returned
                                                                       : link::Sockets::kFailed;
}

}  // namespace

CallerSockets::CallerSockets(const zoned_client_sockets& functions)
    : functions_(functions),
      datagram_(kDatagramBytes),
      all_(this, close_all) {
}

/// At the end, and where memory ran out: nothing here may take any.
void CallerSockets::close_all(void* self) {
    auto& sockets = *static_cast<CallerSockets*>(self);
    for (CallersSocket& slot : sockets.slots_) {
        if (slot.socket >= 0) {
            sockets.functions_.close(sockets.functions_.context, std::exchange(slot.socket, -1));
        }
    }
    if (sockets.datagrams_ >= 0) {
        sockets.functions_.close(sockets.functions_.context, std::exchange(sockets.datagrams_, -1));
    }
}

int CallerSockets::open(const std::string& host, std::uint16_t port) {
    // Room first: memory that runs out must not lose a socket.
    std::size_t number = 0;
    while (number < slots_.size() && slots_[number].used) {
        ++number;
    }
    if (number == slots_.size()) {
        slots_.emplace_back();
    }
    slots_[number] = {true,
                      functions_.open(functions_.context, ZONED_CLIENT_STREAM, host.c_str(), port)};
    return static_cast<int>(number);
}

link::StreamState CallerSockets::state(int stream) const {
    return socket_of(stream) >= 0 ? link::StreamState::kOpen : link::StreamState::kLost;
}

std::string CallerSockets::trouble(int /*stream*/) const {
    return "the game's socket failed";
}

std::ptrdiff_t CallerSockets::send(int stream, std::span<const std::uint8_t> bytes) {
    return checked(
        functions_.send(functions_.context, socket_of(stream), bytes.data(), bytes.size()),
        bytes.size());
}

std::ptrdiff_t CallerSockets::receive(int stream, std::span<std::uint8_t> into) {
    return checked(
        functions_.receive(functions_.context, socket_of(stream), into.data(), into.size()),
        into.size());
}

void CallerSockets::close(int stream) {
    const CallersSocket closed = std::exchange(slots_[static_cast<std::size_t>(stream)], {});
    if (closed.socket >= 0) {
        functions_.close(functions_.context, closed.socket);
    }
}

void CallerSockets::set_peer(std::size_t /*client*/, const std::string& host, std::uint16_t port) {
    std::string peer = host + ':' + std::to_string(port);
    if (datagrams_ >= 0 && peer == peer_) {
        return;
    }
    if (datagrams_ >= 0) {
        functions_.close(functions_.context, std::exchange(datagrams_, -1));
    }
    peer_ = std::move(peer);
    datagrams_ = functions_.open(functions_.context, ZONED_CLIENT_DATAGRAMS, host.c_str(), port);
}

void CallerSockets::queue_datagram(std::size_t /*client*/, link::Bytes datagram) {
    if (datagrams_ < 0 ||
        functions_.send(functions_.context, datagrams_, datagram.data(), datagram.size()) <= 0) {
        ++send_drops_;
    }
}

void CallerSockets::receive_datagrams(
    const std::function<void(std::span<const std::uint8_t>)>& each) {
    // A caller that never says "none" does not hold up the frame.
    constexpr int kMost = 1024;
    for (int i = 0; i < kMost && datagrams_ >= 0; ++i) {
        const std::ptrdiff_t size = checked(
            functions_.receive(functions_.context, datagrams_, datagram_.data(), datagram_.size()),
            datagram_.size());
        if (size <= 0) {
            return;
        }
        each({datagram_.data(), static_cast<std::size_t>(size)});
    }
}

}  // namespace zoned::library
