#include "client-sim/link/sockets/system_sockets.h"

#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace zoned::link {

SystemSockets::SystemSockets(int udp_sockets, bool may_start_threads)
    : may_start_threads_(may_start_threads),
      udp_sockets_(udp_sockets),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      fds_(this, close_fds) {
}

/// At the end, and where memory ran out: nothing here may take any.
void SystemSockets::close_fds(void* self) {
    auto& sockets = *static_cast<SystemSockets*>(self);
    for (SystemStream& stream : sockets.streams_) {
        if (stream.fd >= 0) {
            ::close(std::exchange(stream.fd, -1));
        }
    }
    if (sockets.epoll_ >= 0) {
        ::close(std::exchange(sockets.epoll_, -1));
    }
}

void SystemSockets::set_address(const std::string& host, const SocketAddress& address) {
    names_[host] = address;
}

/// None where it would have to be waited for.
std::optional<SocketAddress> SystemSockets::address_of(const std::string& host) const {
    if (const auto known = names_.find(host); known != names_.end()) {
        return known->second;
    }
    return parse_address(host == "localhost" ? "127.0.0.1" : host);
}

std::string SystemSockets::open_udp(bool v4) {
    udp_.emplace();
    return udp_->open(udp_sockets_, v4 ? AF_INET : AF_INET6);
}

int SystemSockets::open(const std::string& host, std::uint16_t port) {
    std::size_t number = 0;
    while (number < streams_.size() && streams_[number].used) {
        ++number;
    }
    if (number == streams_.size()) {
        streams_.emplace_back();
    }
    SystemStream& stream = streams_[number];
    stream = {};
    stream.used = true;
    if (std::optional<SocketAddress> address = address_of(host)) {
        address->set_port(port);
        connect(stream, *address);
    } else if (may_start_threads_) {
        stream.host = host;
        stream.lookup = std::make_unique<NameLookup>(host, port);
    } else {
        lose(stream, host + " is a name, and no thread may look it up; connect to its address");
    }
    return static_cast<int>(number);
}

void SystemSockets::connect(SystemStream& stream, const SocketAddress& address) {
    stream.address = address;
    stream.fd = ::socket(
        address.storage.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, IPPROTO_TCP);
    const int on = 1;
    epoll_event event{};
    event.events = EPOLLIN | EPOLLOUT | EPOLLRDHUP | EPOLLET;
    event.data.u64 = static_cast<std::uint64_t>(&stream - streams_.data());
    if (stream.fd < 0 || ::setsockopt(stream.fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on)) != 0 ||
        ::epoll_ctl(epoll_, EPOLL_CTL_ADD, stream.fd, &event) != 0 ||
        (::connect(stream.fd, address.get(), address.size) != 0 && errno != EINPROGRESS)) {
        lose(stream, std::strerror(errno));
    }
}

void SystemSockets::lose(SystemStream& stream, std::string why) {
    stream.state = StreamState::kLost;
    stream.trouble = std::move(why);
}

/// Goes on with a stream that is opening.
void SystemSockets::look(SystemStream& stream) {
    if (stream.lookup) {
        const std::optional<Address> found = stream.lookup->answer();
        if (!found) {
            return;
        }
        stream.lookup.reset();
        if (!*found) {
            lose(stream, found->error());
            return;
        }
        set_address(stream.host, **found);
        connect(stream, **found);
        return;
    }
    if (!stream.writable && !stream.readable) {
        return;
    }
    int wrong = 0;
    socklen_t size = sizeof(wrong);
    ::getsockopt(stream.fd, SOL_SOCKET, SO_ERROR, &wrong, &size);
    if (wrong != 0) {
        lose(stream, std::strerror(wrong));
    } else {
        stream.state = StreamState::kOpen;
    }
}

void SystemSockets::poll() {
    std::array<epoll_event, 64> events{};
    int count = 0;
    do {
        count = ::epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), 0);
        for (int i = 0; i < count; ++i) {
            const epoll_event& event = events[static_cast<std::size_t>(i)];
            SystemStream& stream = streams_[event.data.u64];
            stream.readable = true;  // what has failed is read as well
            stream.writable = stream.writable || (event.events & ~EPOLLIN) != 0;
        }
    } while (count == static_cast<int>(events.size()));
    for (SystemStream& stream : streams_) {
        if (stream.used && stream.state == StreamState::kOpening) {
            look(stream);
        }
    }
}

StreamState SystemSockets::state(int stream) const {
    return streams_[static_cast<std::size_t>(stream)].state;
}

std::string SystemSockets::trouble(int number) const {
    const SystemStream& stream = streams_[static_cast<std::size_t>(number)];
    return stream.error != 0 ? std::strerror(stream.error) : stream.trouble;
}

bool SystemSockets::is_local(int stream) const {
    return streams_[static_cast<std::size_t>(stream)].address.is_loopback();
}

bool SystemSockets::is_ready(int number) const {
    const SystemStream& stream = streams_[static_cast<std::size_t>(number)];
    return stream.readable || stream.state == StreamState::kLost;
}

/// The result of a call on the socket; a flag is down until the system raises it again. Runs within
/// OpenSSL, so it must not take memory.
std::ptrdiff_t SystemSockets::outcome(SystemStream& stream, std::ptrdiff_t done, bool& flag) {
    if (done >= 0) {
        return done;
    }
    if (errno == EAGAIN || errno == EWOULDBLOCK) {
        flag = false;
        return 0;
    }
    stream.error = errno;
    return kFailed;
}

std::ptrdiff_t SystemSockets::send(int number, std::span<const std::uint8_t> bytes) {
    SystemStream& stream = streams_[static_cast<std::size_t>(number)];
    if (stream.state != StreamState::kOpen || !stream.writable) {
        return 0;
    }
    const std::ptrdiff_t sent = ::send(stream.fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    return outcome(stream, sent, stream.writable);
}

std::ptrdiff_t SystemSockets::receive(int number, std::span<std::uint8_t> into) {
    SystemStream& stream = streams_[static_cast<std::size_t>(number)];
    if (stream.state != StreamState::kOpen || !stream.readable) {
        return 0;
    }
    const std::ptrdiff_t size = ::recv(stream.fd, into.data(), into.size(), 0);
    return size == 0 ? kEnded : outcome(stream, size, stream.readable);
}

void SystemSockets::close(int number) {
    SystemStream& stream = streams_[static_cast<std::size_t>(number)];
    if (stream.fd >= 0) {
        ::close(stream.fd);
    }
    stream = {};
}

void SystemSockets::set_peer(std::size_t client, const std::string& host, std::uint16_t port) {
    std::optional<SocketAddress> address = address_of(host);
    if (!address) {
        return;
    }
    address->set_port(port);
    if (client >= peers_.size()) {
        peers_.resize(client + 1);
    }
    peers_[client] = *address;
    if (!udp_) {
        // Where there is none, the stream takes over.
        (void)open_udp(address->is_v4());
    }
}

void SystemSockets::queue_datagram(std::size_t client, Bytes datagram) {
    if (client < peers_.size() && peers_[client].size != 0) {
        udp_->queue(client, peers_[client], std::move(datagram));
    }
}

void SystemSockets::flush() {
    if (udp_) {
        udp_->flush();
    }
}

void SystemSockets::receive_datagrams(
    const std::function<void(std::span<const std::uint8_t>)>& each) {
    if (udp_) {
        udp_->receive(each);
    }
}

std::uint64_t SystemSockets::send_drops() const {
    return udp_ ? udp_->send_drops() : 0;
}

}  // namespace zoned::link
