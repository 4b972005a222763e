#include "server/net/udp_endpoint.h"

#include "server/net/bind_error.h"

#include <asio/ip/udp.hpp>
#include <netinet/in.h>
#include <sys/uio.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

namespace zoned::net {

namespace {

/// Batches taken from the socket before other work of the thread gets its turn: as many small
/// datagrams as a kernel's usual buffer of 4 MB holds, so that a turn sees all that waits.
constexpr int kBatchesPerTurn = 96;

using Socket = asio::ip::udp::socket;

std::system_error last_error(const Address& address) {
    return bind_error(std::error_code(errno, std::generic_category()), "UDP", address);
}

int granted_buffer(int fd, int option, int wanted) {
    // A smaller buffer than asked for is no error: the statistics give the granted size.
    setsockopt(fd, SOL_SOCKET, option, &wanted, sizeof wanted);
    int granted = 0;
    socklen_t size = sizeof granted;
    getsockopt(fd, SOL_SOCKET, option, &granted, &size);
    return granted;
}

}  // namespace

struct UdpEndpoint::Impl : std::enable_shared_from_this<UdpEndpoint::Impl> {
    Impl(asio::io_context& io, OnDatagrams callback)
        : socket(io),
          on_datagrams(std::move(callback)) {}

    void open(const UdpSettings& settings);
    void prepare();
    void wait();
    void receive_turn();
    bool receive_batch();
    void flush();

    Socket socket;
    OnDatagrams on_datagrams;
    UdpStats stats;
    int family = AF_INET6;
    std::uint16_t port = 0;

    struct Slots {
        std::array<std::array<std::uint8_t, kMaxDatagram>, kBatch> bytes;
        std::array<sockaddr_storage, kBatch> addresses;
        std::array<iovec, kBatch> vectors;
        std::array<mmsghdr, kBatch> messages;
    };

    std::unique_ptr<Slots> in = std::make_unique<Slots>();
    std::unique_ptr<Slots> out = std::make_unique<Slots>();
    std::size_t queued = 0;
    // Of one turn: the bytes of all datagrams one behind the other, and where each is.
    std::vector<std::uint8_t> arrived;
    std::vector<std::pair<std::size_t, std::size_t>> places;
    std::vector<Datagram> delivered;
};

void UdpEndpoint::Impl::open(const UdpSettings& settings) {
    const auto parsed = parse_address(settings.bind_address, settings.port);
    if (!parsed) {
        throw std::system_error(std::make_error_code(std::errc::invalid_argument), parsed.error());
    }
    family = parsed->is_v4() ? AF_INET : AF_INET6;
    const auto protocol = family == AF_INET ? asio::ip::udp::v4() : asio::ip::udp::v6();
    asio::error_code ec;
    socket.open(protocol, ec);
    if (ec) {
        throw bind_error(ec, "UDP", *parsed);
    }
    const int fd = socket.native_handle();
    if (family == AF_INET6) {
        const int off = 0;  // one socket for both families
        setsockopt(fd, IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
    }
    stats.receive_buffer_bytes = granted_buffer(fd, SO_RCVBUF, settings.receive_buffer_bytes);
    stats.send_buffer_bytes = granted_buffer(fd, SO_SNDBUF, settings.send_buffer_bytes);
    sockaddr_storage where{};
    const socklen_t length = to_socket_address(*parsed, family, where);
    if (::bind(fd, reinterpret_cast<const sockaddr*>(&where), length) != 0) {
        throw last_error(*parsed);
    }
    sockaddr_storage bound{};
    socklen_t size = sizeof bound;
    if (getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &size) != 0) {
        throw last_error(*parsed);
    }
    port = from_socket_address(bound).port;
    socket.native_non_blocking(true, ec);
    if (ec) {
        throw bind_error(ec, "UDP", *parsed);
    }
    prepare();
}

void UdpEndpoint::Impl::prepare() {
    for (Slots* slots : {in.get(), out.get()}) {
        for (std::size_t i = 0; i < kBatch; ++i) {
            slots->vectors[i] = {slots->bytes[i].data(), kMaxDatagram};
            slots->messages[i] = {};
            slots->messages[i].msg_hdr.msg_iov = &slots->vectors[i];
            slots->messages[i].msg_hdr.msg_iovlen = 1;
            slots->messages[i].msg_hdr.msg_name = &slots->addresses[i];
        }
    }
}

void UdpEndpoint::Impl::wait() {
    socket.async_wait(Socket::wait_read, [self = shared_from_this()](const asio::error_code& ec) {
        if (ec) {
            return;  // closed
        }
        self->receive_turn();
        if (self->socket.is_open()) {
            self->wait();
        }
    });
}

void UdpEndpoint::Impl::receive_turn() {
    arrived.clear();
    places.clear();
    delivered.clear();
    for (int i = 0; i < kBatchesPerTurn; ++i) {
        if (!receive_batch()) {
            break;
        }
    }
    for (std::size_t i = 0; i < delivered.size(); ++i) {
        delivered[i].bytes =
            std::span<const std::uint8_t>(arrived).subspan(places[i].first, places[i].second);
    }
    if (!delivered.empty()) {
        on_datagrams(delivered);
    }
}

/// False when the socket holds no more.
bool UdpEndpoint::Impl::receive_batch() {
    for (mmsghdr& message : in->messages) {
        message.msg_hdr.msg_namelen = sizeof(sockaddr_storage);
    }
    const int n =
        recvmmsg(socket.native_handle(), in->messages.data(), kBatch, MSG_DONTWAIT, nullptr);
    if (n < 0) {
        if (errno == EINTR) {
            return true;
        }
        if (errno != EAGAIN && errno != EWOULDBLOCK) {
            ++stats.receive_errors;  // e.g. an ICMP message; the socket goes on
        }
        return false;
    }
    ++stats.receive_calls;
    for (int i = 0; i < n; ++i) {
        const mmsghdr& message = in->messages[static_cast<std::size_t>(i)];
        if ((message.msg_hdr.msg_flags & MSG_TRUNC) != 0) {
            ++stats.truncated;
            continue;
        }
        const auto slot = static_cast<std::size_t>(i);
        stats.received_bytes += message.msg_len;
        places.emplace_back(arrived.size(), message.msg_len);
        arrived.insert(
            arrived.end(), in->bytes[slot].data(), in->bytes[slot].data() + message.msg_len);
        delivered.push_back({from_socket_address(in->addresses[slot]), {}});
        ++stats.received;
    }
    return static_cast<std::size_t>(n) == kBatch;
}

void UdpEndpoint::Impl::flush() {
    std::size_t done = 0;
    while (done < queued) {
        const int n = sendmmsg(socket.native_handle(),
                               out->messages.data() + done,
                               static_cast<unsigned>(queued - done),
                               MSG_DONTWAIT);
        if (n > 0) {
            ++stats.send_calls;
            for (std::size_t i = done; i < done + static_cast<std::size_t>(n); ++i) {
                stats.sent_bytes += out->vectors[i].iov_len;
            }
            stats.sent += static_cast<std::uint64_t>(n);
            done += static_cast<std::size_t>(n);
        } else if (errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS) {
            stats.dropped_full += queued - done;
            break;
        } else if (errno != EINTR) {
            // The first one of the rest was refused; those behind it may still go.
            ++stats.dropped_error;
            ++done;
        }
    }
    queued = 0;
}

UdpEndpoint::UdpEndpoint(asio::io_context& io,
                         const UdpSettings& settings,
                         OnDatagrams on_datagrams)
    : impl_(std::make_shared<Impl>(io, std::move(on_datagrams))) {
    impl_->open(settings);
}

UdpEndpoint::~UdpEndpoint() {
    close();
}

void UdpEndpoint::start() {
    impl_->wait();
}

void UdpEndpoint::close() {
    asio::error_code ignored;
    impl_->socket.close(ignored);
}

std::uint16_t UdpEndpoint::port() const {
    return impl_->port;
}

void UdpEndpoint::queue_send(const Address& to, std::span<const std::uint8_t> bytes) {
    Impl& impl = *impl_;
    if (!impl.socket.is_open() || bytes.size() > kMaxDatagram) {
        ++impl.stats.dropped_error;
        return;
    }
    const std::size_t i = impl.queued;
    const socklen_t length = to_socket_address(to, impl.family, impl.out->addresses[i]);
    if (length == 0) {
        ++impl.stats.dropped_error;
        return;
    }
    impl.out->messages[i].msg_hdr.msg_namelen = length;
    impl.out->vectors[i].iov_len = bytes.size();
    if (!bytes.empty()) {
        std::memcpy(impl.out->bytes[i].data(), bytes.data(), bytes.size());
    }
    if (++impl.queued == kBatch) {
        impl.flush();
    }
}

void UdpEndpoint::flush() {
    if (impl_->socket.is_open()) {
        impl_->flush();
    }
}

const UdpStats& UdpEndpoint::stats() const {
    return impl_->stats;
}

}  // namespace zoned::net
