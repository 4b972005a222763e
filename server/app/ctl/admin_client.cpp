#include "server/app/ctl/admin_client.h"

#include <netdb.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace zoned::app {

namespace {

constexpr std::size_t kMostAnswerBytes = 64U << 20U;
constexpr time_t kPatience_s = 35;

/// Closes itself.
class ClientSocket {
  public:
    explicit ClientSocket(int fd) : fd_(fd) {}

    ~ClientSocket() {
        if (fd_ >= 0) {
            ::close(fd_);
        }
    }

    ClientSocket(const ClientSocket&) = delete;
    ClientSocket& operator=(const ClientSocket&) = delete;

    [[nodiscard]] int fd() const { return fd_; }

  private:
    int fd_;
};

std::string address_text(const AdminTarget& target) {
    const bool six = target.host.find(':') != std::string::npos;
    return (six ? "[" + target.host + "]" : target.host) + ":" + std::to_string(target.port);
}

int connect_to(const AdminTarget& target) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const int code =
        ::getaddrinfo(target.host.c_str(), std::to_string(target.port).c_str(), &hints, &found);
    if (code != 0) {
        throw std::runtime_error(address_text(target) + ": " + ::gai_strerror(code));
    }
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> list(found, &::freeaddrinfo);
    int error = ECONNREFUSED;
    for (const addrinfo* at = found; at != nullptr; at = at->ai_next) {
        const int fd = ::socket(at->ai_family, at->ai_socktype | SOCK_CLOEXEC, 0);
        if (fd >= 0 && ::connect(fd, at->ai_addr, at->ai_addrlen) == 0) {
            return fd;
        }
        error = errno;
        if (fd >= 0) {
            ::close(fd);
        }
    }
    throw std::system_error(error,
                            std::generic_category(),
                            "no server answers at " + address_text(target) +
                                " (is it running, and is this its admin port?)");
}

void send_all(int fd, const std::string& text) {
    std::size_t done = 0;
    while (done < text.size()) {
        const ssize_t sent = ::send(fd, text.data() + done, text.size() - done, MSG_NOSIGNAL);
        if (sent < 0 && errno != EINTR) {
            // The server may have answered and closed before it had read everything.
            return;
        }
        done += sent > 0 ? static_cast<std::size_t>(sent) : 0;
    }
}

std::string receive_all(int fd, const AdminTarget& target) {
    std::string text;
    std::array<char, 65536> part{};
    for (;;) {
        const ssize_t got = ::recv(fd, part.data(), part.size(), 0);
        if (got < 0 && errno == EINTR) {
            continue;
        }
        if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
            throw std::runtime_error(address_text(target) + " did not answer in time");
        }
        if (got <= 0) {
            return text;
        }
        text.append(part.data(), static_cast<std::size_t>(got));
        if (text.size() > kMostAnswerBytes) {
            throw std::runtime_error(address_text(target) + " sends more than 64 MiB");
        }
    }
}

/// A body in chunks (RFC 9112, 7.1), as Agones' sidecar sends it.
std::string joined_chunks(std::string_view rest, const AdminTarget& target) {
    std::string body;
    for (;;) {
        std::size_t length = 0;
        const std::size_t line = rest.find("\r\n");
        const auto [end, error] =
            std::from_chars(rest.data(), rest.data() + std::min(line, rest.size()), length, 16);
        if (line == std::string_view::npos || error != std::errc() || end == rest.data() ||
            length > rest.size() - line - 2) {
            throw std::runtime_error(address_text(target) + " sends a body that is cut off");
        }
        if (length == 0) {
            return body;
        }
        body += rest.substr(line + 2, length);
        rest.remove_prefix(std::min(line + 2 + length + 2, rest.size()));
    }
}

bool comes_in_chunks(std::string headers) {
    std::transform(headers.begin(), headers.end(), headers.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c;
    });
    return headers.find("\r\ntransfer-encoding: chunked") != std::string::npos;
}

/// The server closes after its answer: the body is what follows the headers.
AdminAnswer parse_answer(const std::string& text, const AdminTarget& target) {
    AdminAnswer answer;
    const std::size_t body = text.find("\r\n\r\n");
    const char* const status = text.data() + 9;
    if (!text.starts_with("HTTP/1.1 ") || text.size() < 12 || body == std::string::npos ||
        std::from_chars(status, status + 3, answer.status).ptr != status + 3) {
        throw std::runtime_error(address_text(target) +
                                 " does not answer in HTTP: is this a server's admin port?");
    }
    answer.body = text.substr(body + 4);
    if (comes_in_chunks(text.substr(0, body))) {
        answer.body = joined_chunks(answer.body, target);
    }
    return answer;
}

}  // namespace

AdminTarget parse_admin_address(const std::string& text) {
    AdminTarget target;
    const std::size_t colon = text.rfind(':');
    unsigned port = 0;
    const char* const end = text.data() + text.size();
    if (colon == std::string::npos ||
        std::from_chars(text.data() + colon + 1, end, port).ptr != end || port == 0 ||
        port > 65535) {
        throw std::invalid_argument("'" + text + "' is no HOST:PORT");
    }
    target.host = text.substr(0, colon);
    if (target.host.size() > 2 && target.host.front() == '[' && target.host.back() == ']') {
        target.host = target.host.substr(1, target.host.size() - 2);
    }
    target.port = static_cast<std::uint16_t>(port);
    return target;
}

AdminAnswer ask_admin(const AdminTarget& target,
                      const std::string& method,
                      const std::string& path,
                      const std::string& body) {
    const ClientSocket socket(connect_to(target));
    const timeval patience{kPatience_s, 0};
    ::setsockopt(socket.fd(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    ::setsockopt(socket.fd(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
    std::string request = method + " " + path + " HTTP/1.1\r\nHost: " + address_text(target) +
                          "\r\nConnection: close\r\nAuthorization: Bearer " + target.token + "\r\n";
    if (method == "POST") {
        request +=
            "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) +
            "\r\n";
    }
    send_all(socket.fd(), request + "\r\n" + body);
    return parse_answer(receive_all(socket.fd(), target), target);
}

}  // namespace zoned::app
