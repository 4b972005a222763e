#include "server/net/udp_endpoint.h"

#include "server/net/bind_error.h"

#include <asio/posix/stream_descriptor.hpp>
#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>
#include <vector>

namespace zoned::net {

namespace {

/// Batches taken from the socket before other work of the thread gets its turn: as many small
/// datagrams as a kernel's usual buffer of 4 MB holds, so that a turn sees all that waits.
constexpr int kBatchesPerTurn = 96;

/// Room for the one time stamp that comes with a datagram.
constexpr std::size_t kControlBytes = 64;
static_assert(kControlBytes >= CMSG_SPACE(sizeof(timespec)));

double wall_seconds() {
    timespec t{};
    clock_gettime(CLOCK_REALTIME, &t);  // the clock of the kernel's time stamps
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double monotonic_seconds() {
    const auto since_boot = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration<double>(since_boot).count();
}

/// The same moment on the wall clock and on the monotonic one. A thread may lose its turn between
/// the two: the second is read last, so that no arrival seems earlier than it was, and a round trip
/// never shorter.
std::pair<double, double> both_clocks() {
    constexpr double kTogether_s = 20e-6;
    constexpr int kTries = 4;
    double before_s = monotonic_seconds();
    for (int i = 1;; ++i) {
        const double wall_s = wall_seconds();
        const double now_s = monotonic_seconds();
        if (now_s - before_s <= kTogether_s || i == kTries) {
            return {wall_s, now_s};
        }
        before_s = now_s;
    }
}

/// When a datagram reached this machine (SO_TIMESTAMPNS); `otherwise` where the kernel did not say.
double arrival_of(msghdr& header, double otherwise) {
    for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr; c = CMSG_NXTHDR(&header, c)) {
        if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_TIMESTAMPNS) {
            timespec t{};
            std::memcpy(&t, CMSG_DATA(c), sizeof t);
            return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
        }
    }
    return otherwise;
}

/// A file descriptor that closes itself.
class OwnedDescriptor {
  public:
    OwnedDescriptor() = default;

    ~OwnedDescriptor() { reset(); }

    OwnedDescriptor(const OwnedDescriptor&) = delete;
    OwnedDescriptor& operator=(const OwnedDescriptor&) = delete;

    void reset(int fd = -1) {
        if (fd_ >= 0) {
            ::close(fd_);
        }
        fd_ = fd;
    }

    [[nodiscard]] int get() const { return fd_; }

    [[nodiscard]] bool is_open() const { return fd_ >= 0; }

  private:
    int fd_ = -1;
};

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
        : readiness(io),
          on_datagrams(std::move(callback)) {}

    void open(const UdpSettings& settings);
    void prepare();
    void ask_for_readiness(bool on);
    void wait();
    void receive_turn();
    bool receive_batch();
    void flush();

    OwnedDescriptor socket;
    // The reactor of an io_context wakes its thread for each datagram of a socket that it knows,
    // whether or not a handler waits. So it knows this epoll instance in the socket's place.
    asio::posix::stream_descriptor readiness;
    bool held = false;
    double turned_s = 0.0;  // when the last turn began; monotonic
    OnDatagrams on_datagrams;
    UdpStats stats;
    int family = AF_INET6;
    std::uint16_t port = 0;

    struct Slots {
        std::array<std::array<std::uint8_t, kMaxDatagram>, kBatch> bytes;
        std::array<sockaddr_storage, kBatch> addresses;
        std::array<iovec, kBatch> vectors;
        alignas(cmsghdr) std::array<std::array<std::uint8_t, kControlBytes>, kBatch> controls;
        std::array<mmsghdr, kBatch> messages;
    };

    std::unique_ptr<Slots> in = std::make_unique<Slots>();
    std::unique_ptr<Slots> out = std::make_unique<Slots>();
    std::size_t queued = 0;
    std::size_t used_slots = kBatch;  // of `in`: the kernel wrote there
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
    socket.reset(::socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (!socket.is_open()) {
        throw last_error(*parsed);
    }
    const int fd = socket.get();
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
    const int on = 1;
    setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
    const int poller = ::epoll_create1(EPOLL_CLOEXEC);
    if (poller < 0) {
        throw last_error(*parsed);
    }
    asio::error_code ec;
    readiness.assign(poller, ec);
    if (ec) {
        ::close(poller);
        throw bind_error(ec, "UDP", *parsed);
    }
    epoll_event nothing{};
    nothing.events = EPOLLONESHOT;
    if (::epoll_ctl(poller, EPOLL_CTL_ADD, fd, &nothing) != 0) {
        throw last_error(*parsed);
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
    for (std::size_t i = 0; i < kBatch; ++i) {
        in->messages[i].msg_hdr.msg_control = in->controls[i].data();
    }
}

/// The next datagram, or those that wait, make `readiness` readable once.
void UdpEndpoint::Impl::ask_for_readiness(bool on) {
    epoll_event event{};
    event.events = EPOLLONESHOT | (on ? static_cast<std::uint32_t>(EPOLLIN) : 0U);
    ::epoll_ctl(readiness.native_handle(), EPOLL_CTL_MOD, socket.get(), &event);
}

void UdpEndpoint::Impl::wait() {
    readiness.async_wait(asio::posix::stream_descriptor::wait_read,
                         [self = shared_from_this()](const asio::error_code& ec) {
                             if (ec || !self->socket.is_open()) {
                                 return;  // closed
                             }
                             epoll_event event{};
                             ::epoll_wait(
                                 self->readiness.native_handle(), &event, 1, 0);  // it is heard
                             if (!self->held) {
                                 self->receive_turn();
                             }
                             if (self->socket.is_open()) {
                                 self->wait();
                                 self->ask_for_readiness(!self->held);
                             }
                         });
}

void UdpEndpoint::Impl::receive_turn() {
    arrived.clear();
    places.clear();
    delivered.clear();
    const double turn_s = monotonic_seconds();
    for (int i = 0; i < kBatchesPerTurn; ++i) {
        if (!receive_batch()) {
            break;
        }
    }
    turned_s = turn_s;
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
    for (std::size_t i = 0; i < used_slots; ++i) {
        in->messages[i].msg_hdr.msg_namelen = sizeof(sockaddr_storage);
        in->messages[i].msg_hdr.msg_controllen = kControlBytes;
    }
    const int n = recvmmsg(socket.get(), in->messages.data(), kBatch, MSG_DONTWAIT, nullptr);
    used_slots = static_cast<std::size_t>(std::max(0, n));
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
    const auto [wall_s, now_s] = both_clocks();
    // Whatever waited before the last turn was read in it; and the wall clock may be set.
    const double most_s = std::max(0.0, now_s - turned_s);
    for (int i = 0; i < n; ++i) {
        mmsghdr& message = in->messages[static_cast<std::size_t>(i)];
        if ((message.msg_hdr.msg_flags & MSG_TRUNC) != 0) {
            ++stats.truncated;
            continue;
        }
        const auto slot = static_cast<std::size_t>(i);
        stats.received_bytes += message.msg_len;
        places.emplace_back(arrived.size(), message.msg_len);
        arrived.insert(
            arrived.end(), in->bytes[slot].data(), in->bytes[slot].data() + message.msg_len);
        const double waited_s =
            std::clamp(wall_s - arrival_of(message.msg_hdr, wall_s), 0.0, most_s);
        delivered.push_back({from_socket_address(in->addresses[slot]), {}, now_s - waited_s});
        ++stats.received;
    }
    return static_cast<std::size_t>(n) == kBatch;
}

void UdpEndpoint::Impl::flush() {
    std::size_t done = 0;
    while (done < queued) {
        const int n = sendmmsg(socket.get(),
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
    impl_->turned_s = monotonic_seconds();
    impl_->wait();
    watch();
}

void UdpEndpoint::hold() {
    if (!impl_->held && impl_->socket.is_open()) {
        impl_->held = true;
        impl_->ask_for_readiness(false);
    }
}

void UdpEndpoint::read() {
    if (impl_->socket.is_open()) {
        const std::shared_ptr<Impl> keep = impl_;  // a callback may close or destroy this
        keep->receive_turn();
    }
}

void UdpEndpoint::watch() {
    if (impl_->socket.is_open()) {
        impl_->held = false;
        impl_->ask_for_readiness(true);
    }
}

void UdpEndpoint::close() {
    asio::error_code ignored;
    impl_->readiness.close(ignored);
    impl_->socket.reset();
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
