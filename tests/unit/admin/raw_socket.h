// RawSocket: a blocking TCP client that sends any bytes, for tests of servers that face hostile
// ones.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <string>
#include <utility>

namespace zoned::testing_admin {

/// Waits at most ten seconds for anything.
class RawSocket {
  public:
    explicit RawSocket(std::uint16_t port, int receive_buffer_bytes = 0) {
        fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        if (fd_ < 0) {
            return;
        }
        if (receive_buffer_bytes > 0) {
            ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes, sizeof(int));
        }
        const timeval patience{10, 0};
        ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
        ::setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(port);
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        if (::connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) != 0) {
            ::close(fd_);
            fd_ = -1;
        }
    }

    ~RawSocket() {
        if (fd_ >= 0) {
            ::close(fd_);
        }
    }

    RawSocket(RawSocket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

    RawSocket(const RawSocket&) = delete;
    RawSocket& operator=(const RawSocket&) = delete;
    RawSocket& operator=(RawSocket&&) = delete;

    [[nodiscard]] bool open() const { return fd_ >= 0; }

    /// False when the other side no longer takes anything.
    bool send(const std::string& text) const {
        std::size_t done = 0;
        while (done < text.size()) {
            const ssize_t sent = ::send(fd_, text.data() + done, text.size() - done, MSG_NOSIGNAL);
            if (sent <= 0) {
                return false;
            }
            done += static_cast<std::size_t>(sent);
        }
        return true;
    }

    /// All bytes until the other side closes.
    std::string receive_all() const {
        std::string text;
        std::array<char, 65536> part{};
        for (;;) {
            const ssize_t got = ::recv(fd_, part.data(), part.size(), 0);
            if (got <= 0) {
                return text;
            }
            text.append(part.data(), static_cast<std::size_t>(got));
        }
    }

    /// Takes what is there, and returns how many bytes it was; 0 where the other side has closed.
    std::size_t receive_some() const {
        std::array<char, 65536> part{};
        const ssize_t got = ::recv(fd_, part.data(), part.size(), 0);
        return got > 0 ? static_cast<std::size_t>(got) : 0;
    }

    /// Bytes up to the first occurrence of `end`, with it.
    std::string receive_until(const std::string& end) const {
        std::string text;
        char c = 0;
        while (!text.ends_with(end) && ::recv(fd_, &c, 1, 0) == 1) {
            text += c;
        }
        return text;
    }

    /// True when the other side has closed and sends nothing more. Bytes sent after its end make
    /// the kernel report a reset or a broken pipe; only running out of patience is no end.
    bool closed() const {
        char c = 0;
        const ssize_t got = ::recv(fd_, &c, 1, 0);
        return got == 0 || (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK);
    }

  private:
    int fd_ = -1;
};

/// Sends a request on a connection of its own and returns everything that comes back.
inline std::string send_raw(std::uint16_t port, const std::string& request) {
    const RawSocket socket(port);
    socket.send(request);
    return socket.receive_all();
}

/// A GET that ends its connection.
inline std::string get(std::uint16_t port,
                       const std::string& target,
                       const std::string& more = "") {
    return send_raw(
        port,
        "GET " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n" + more + "\r\n");
}

/// The status of an answer; 0 when there is none.
inline int status_of(const std::string& answer) {
    return answer.size() > 12 && answer.starts_with("HTTP/1.1 ") ? std::stoi(answer.substr(9, 3))
                                                                 : 0;
}

}  // namespace zoned::testing_admin
