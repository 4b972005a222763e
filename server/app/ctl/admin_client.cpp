#include "server/app/ctl/admin_client.h"

#include <netdb.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
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

/// The bytes of one question and its answer, over a socket or over TLS on it.
class AskConnection {
  public:
    explicit AskConnection(const AdminTarget& target)
        : target_(target),
          socket_(connect_to(target)) {
        const timeval patience{kPatience_s, 0};
        ::setsockopt(socket_.fd(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
        ::setsockopt(socket_.fd(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
        if (target.tls) {
            begin_tls();
        }
    }

    /// The server may have answered and closed before it had read everything: that shows when its
    /// answer is read.
    void send(const std::string& text) {
        std::size_t done = 0;
        while (done < text.size()) {
            const long sent =
                ssl_ ? SSL_write(
                           ssl_.get(), text.data() + done, static_cast<int>(text.size() - done))
                     : ::send(socket_.fd(), text.data() + done, text.size() - done, MSG_NOSIGNAL);
            if (sent < 0 && errno == EINTR && !ssl_) {
                continue;
            }
            if (sent <= 0) {
                return;
            }
            done += static_cast<std::size_t>(sent);
        }
    }

    std::string receive() {
        std::string text;
        std::array<char, 65536> part{};
        for (;;) {
            errno = 0;
            const long got = ssl_ ? SSL_read(ssl_.get(), part.data(), static_cast<int>(part.size()))
                                  : ::recv(socket_.fd(), part.data(), part.size(), 0);
            if (got < 0 && errno == EINTR) {
                continue;
            }
            if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
                throw std::runtime_error(address_text(target_) + " did not answer in time");
            }
            if (got <= 0) {
                return text;
            }
            text.append(part.data(), static_cast<std::size_t>(got));
            if (text.size() > kMostAnswerBytes) {
                throw std::runtime_error(address_text(target_) + " sends more than 64 MiB");
            }
        }
    }

  private:
    void begin_tls() {
        context_.reset(SSL_CTX_new(TLS_client_method()));
        const std::string& file = target_.certificate_file;
        SSL_CTX_set_verify(context_.get(), SSL_VERIFY_PEER, nullptr);
        X509_VERIFY_PARAM_set_flags(SSL_CTX_get0_param(context_.get()), X509_V_FLAG_PARTIAL_CHAIN);
        const int trusted = file.empty() ? SSL_CTX_set_default_verify_paths(context_.get())
                                         : SSL_CTX_load_verify_file(context_.get(), file.c_str());
        if (trusted != 1) {
            throw std::runtime_error("cannot read certificates from " +
                                     (file.empty() ? "the system" : file));
        }
        ssl_.reset(SSL_new(context_.get()));
        SSL_set_fd(ssl_.get(), socket_.fd());
        SSL_set_tlsext_host_name(ssl_.get(), target_.host.c_str());
        if (SSL_connect(ssl_.get()) != 1) {
            const long why = SSL_get_verify_result(ssl_.get());
            throw std::runtime_error(
                address_text(target_) +
                (why != X509_V_OK
                     ? std::string(" shows a certificate that is not trusted: ") +
                           X509_verify_cert_error_string(why) +
                           " (name the server's certificate with --certificate)"
                     : std::string(" does not speak TLS: is this a server's admin port?")));
        }
        if (!is_named()) {
            throw std::runtime_error(address_text(target_) +
                                     " shows a certificate for another name (name the server's "
                                     "own certificate with --certificate)");
        }
    }

    /// A certificate that is trusted itself needs no name; one that is trusted for its signer does.
    [[nodiscard]] bool is_named() const {
        const std::unique_ptr<X509, decltype(&X509_free)> shown(
            SSL_get1_peer_certificate(ssl_.get()), &X509_free);
        const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
            target_.certificate_file.empty() ? nullptr
                                             : std::fopen(target_.certificate_file.c_str(), "r"),
            [](std::FILE* open) { return open != nullptr ? std::fclose(open) : 0; });
        if (file) {
            const std::unique_ptr<X509, decltype(&X509_free)> own(
                PEM_read_X509(file.get(), nullptr, nullptr, nullptr), &X509_free);
            if (own && X509_cmp(own.get(), shown.get()) == 0) {
                return true;
            }
        }
        return X509_check_host(shown.get(), target_.host.c_str(), 0, 0, nullptr) == 1 ||
               X509_check_ip_asc(shown.get(), target_.host.c_str(), 0) == 1;
    }

    const AdminTarget& target_;
    ClientSocket socket_;
    std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context_{nullptr, &SSL_CTX_free};
    std::unique_ptr<SSL, decltype(&SSL_free)> ssl_{nullptr, &SSL_free};
};

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

AdminTarget parse_admin_address(const std::string& whole) {
    constexpr std::string_view kSecure = "https://";
    AdminTarget target;
    target.tls = whole.starts_with(kSecure);
    const std::string text = target.tls ? whole.substr(kSecure.size()) : whole;
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
    AskConnection connection(target);
    std::string request = method + " " + path + " HTTP/1.1\r\nHost: " + address_text(target) +
                          "\r\nConnection: close\r\nAuthorization: Bearer " + target.token + "\r\n";
    if (method == "POST") {
        request +=
            "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) +
            "\r\n";
    }
    connection.send(request + "\r\n" + body);
    return parse_answer(connection.receive(), target);
}

}  // namespace zoned::app
