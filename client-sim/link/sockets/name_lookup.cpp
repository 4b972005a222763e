#include "client-sim/link/sockets/name_lookup.h"

#include <netdb.h>
#include <pthread.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>

namespace zoned::link {

namespace {

/// The longest name that there is (RFC 1035, section 2.3.4), and its closing 0.
constexpr std::size_t kHostBytes = 256;

/// 0, or what getaddrinfo() says. Takes no memory but the C library's: it also runs on a thread.
int resolve(const char* host, int flags, SocketAddress& out) {
    addrinfo hints{};
    hints.ai_flags = flags;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    int wrong = ::getaddrinfo(host, nullptr, &hints, &found);
    if (wrong != 0 && (flags & AI_NUMERICHOST) == 0 && std::strcmp(host, "localhost") == 0) {
        // Its meaning is fixed (RFC 6761, 6.3), also on a machine without /etc/hosts.
        wrong = ::getaddrinfo("127.0.0.1", nullptr, &hints, &found);
    }
    if (wrong != 0) {
        return wrong;
    }
    const addrinfo* best = found;
    for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
        if (each->ai_family == AF_INET) {
            best = each;
            break;
        }
    }
    std::memcpy(&out.storage, best->ai_addr, best->ai_addrlen);
    out.size = best->ai_addrlen;
    ::freeaddrinfo(found);
    return 0;
}

Address result_of(int wrong, const char* host, std::uint16_t port, SocketAddress found) {
    if (wrong != 0) {
        return Address::failure("cannot resolve " + std::string(host) + ":" + std::to_string(port) +
                                ": " + ::gai_strerror(wrong) + "; check host and port");
    }
    found.set_port(port);
    return found;
}

}  // namespace

bool SocketAddress::is_loopback() const {
    if (is_v4()) {
        const auto& v4 = reinterpret_cast<const sockaddr_in&>(storage);
        return ntohl(v4.sin_addr.s_addr) >> 24U == IN_LOOPBACKNET;
    }
    return IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6&>(storage).sin6_addr);
}

void SocketAddress::set_port(std::uint16_t port) {
    // At the same place in both.
    reinterpret_cast<sockaddr_in&>(storage).sin_port = htons(port);
}

std::optional<SocketAddress> parse_address(const std::string& host) {
    SocketAddress found;
    return resolve(host.c_str(), AI_NUMERICHOST, found) == 0 ? std::optional(found) : std::nullopt;
}

bool is_loopback(const std::string& host) {
    const auto address = parse_address(host);
    return host == "localhost" || (address && address->is_loopback());
}

Address look_up(const std::string& host, std::uint16_t port) {
    SocketAddress found;
    const int wrong = resolve(host.c_str(), 0, found);
    return result_of(wrong, host.c_str(), port, found);
}

/// Memory of the C library: it lives as long as the slower of the two.
struct NameLookup::Shared {
    std::atomic<int> owners = 2;
    std::atomic<bool> done = false;
    std::array<char, kHostBytes> host{};
    std::uint16_t port = 0;
    int wrong = EAI_MEMORY;
    SocketAddress found;

    static void leave(void* shared) {
        if (--static_cast<Shared*>(shared)->owners == 0) {
            std::free(shared);
        }
    }

    static void* run(void* shared) {
        auto& self = *static_cast<Shared*>(shared);
        self.wrong = resolve(self.host.data(), 0, self.found);
        self.done = true;
        leave(shared);
        return nullptr;
    }

    static Shared* start(const std::string& host, std::uint16_t port) {
        void* const memory = std::malloc(sizeof(Shared));
        if (memory == nullptr) {
            return nullptr;
        }
        auto* const shared = new (memory) Shared;
        shared->port = port;
        host.copy(shared->host.data(), kHostBytes - 1);
        pthread_t thread{};
        if (host.size() >= kHostBytes || ::pthread_create(&thread, nullptr, run, shared) != 0) {
            shared->wrong = host.size() >= kHostBytes ? EAI_NONAME : EAI_MEMORY;
            shared->owners = 1;
            shared->done = true;
            return shared;
        }
        ::pthread_detach(thread);
        return shared;
    }
};

NameLookup::NameLookup(const std::string& host, std::uint16_t port)
    : shared_(Shared::start(host, port), Shared::leave) {
}

std::optional<Address> NameLookup::answer() const {
    const auto* const shared = static_cast<const Shared*>(shared_.get());
    if (shared == nullptr) {
        return Address::failure("there is no memory to look up a name");
    }
    if (!shared->done) {
        return std::nullopt;
    }
    return result_of(shared->wrong, shared->host.data(), shared->port, shared->found);
}

}  // namespace zoned::link
