#include "client-sim/link/sockets/udp_pool.h"

#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

namespace zoned::link {

namespace {

constexpr int kBufferBytes = 4 << 20;

}  // namespace

UdpPool::UdpPool() : slots_(kBatch * kSlotBytes), fds_(this, close) {
}

/// At the end, and where memory ran out: nothing here may take any.
void UdpPool::close(void* self) {
    for (const int fd : static_cast<UdpPool*>(self)->sockets_) {
        ::close(fd);
    }
}

std::string UdpPool::open(int sockets, int family) {
    // Room first: memory that runs out must not lose a socket.
    sockets_.reserve(static_cast<std::size_t>(sockets));
    queues_.resize(static_cast<std::size_t>(sockets));
    for (int i = 0; i < sockets; ++i) {
        const int fd = ::socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
        if (fd < 0) {
            return std::string("cannot open a UDP socket: ") + std::strerror(errno);
        }
        sockets_.push_back(fd);
        // The kernel may grant less; bursts are then lost and show up as loss in the report.
        ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &kBufferBytes, sizeof(kBufferBytes));
        ::setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &kBufferBytes, sizeof(kBufferBytes));
    }
    return {};
}

void UdpPool::queue(std::size_t index, const SocketAddress& to, Bytes datagram) {
    if (sockets_.empty()) {
        ++send_drops_;
        return;
    }
    queues_[index % sockets_.size()].push_back({to, std::move(datagram)});
}

void UdpPool::flush() {
    for (std::size_t i = 0; i < sockets_.size(); ++i) {
        if (!queues_[i].empty()) {
            flush_socket(i);
        }
    }
}

void UdpPool::flush_socket(std::size_t index) {
    std::vector<Outgoing>& queue = queues_[index];
    std::size_t sent = 0;
    while (sent < queue.size()) {
        const std::size_t batch = std::min(kBatch, queue.size() - sent);
        for (std::size_t i = 0; i < batch; ++i) {
            Outgoing& out = queue[sent + i];
            vectors_[i] = {out.bytes.data(), out.bytes.size()};
            headers_[i] = {};
            headers_[i].msg_hdr.msg_name = &out.to.storage;
            headers_[i].msg_hdr.msg_namelen = out.to.size;
            headers_[i].msg_hdr.msg_iov = &vectors_[i];
            headers_[i].msg_hdr.msg_iovlen = 1;
        }
        const int done =
            ::sendmmsg(sockets_[index], headers_.data(), static_cast<unsigned>(batch), 0);
        if (done > 0) {
            sent += static_cast<std::size_t>(done);
        } else if (errno == EINTR) {
            continue;
        } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
            send_drops_ += queue.size() - sent;
            break;
        } else {
            // A refused port of a server that just went away concerns this one datagram only.
            ++send_drops_;
            ++sent;
        }
    }
    queue.clear();
}

void UdpPool::receive(const std::function<void(std::span<const std::uint8_t>)>& each) {
    for (const int fd : sockets_) {
        for (;;) {
            for (std::size_t i = 0; i < kBatch; ++i) {
                vectors_[i] = {slots_.data() + i * kSlotBytes, kSlotBytes};
                headers_[i] = {};
                headers_[i].msg_hdr.msg_iov = &vectors_[i];
                headers_[i].msg_hdr.msg_iovlen = 1;
            }
            const int got = ::recvmmsg(fd, headers_.data(), kBatch, MSG_DONTWAIT, nullptr);
            if (got <= 0) {
                break;
            }
            for (std::size_t i = 0; i < static_cast<std::size_t>(got); ++i) {
                each({slots_.data() + i * kSlotBytes, headers_[i].msg_len});
            }
            if (static_cast<std::size_t>(got) < kBatch) {
                break;
            }
        }
    }
}

}  // namespace zoned::link
