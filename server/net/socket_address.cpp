#include "server/net/socket_address.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace zoned::net {

namespace {

constexpr auto kMappedPrefix = Address::kMappedPrefix;

void map_v4(const in_addr& in, std::uint8_t* ip) {
    std::copy(kMappedPrefix.begin(), kMappedPrefix.end(), ip);
    std::memcpy(ip + kMappedPrefix.size(), &in, 4);
}

}  // namespace

std::string text_of(const Address& address) {
    std::array<char, INET6_ADDRSTRLEN> buffer{};
    if (address.is_v4()) {
        inet_ntop(AF_INET, address.ip + kMappedPrefix.size(), buffer.data(), buffer.size());
        return std::string(buffer.data()) + ":" + std::to_string(address.port);
    }
    inet_ntop(AF_INET6, address.ip, buffer.data(), buffer.size());
    return "[" + std::string(buffer.data()) + "]:" + std::to_string(address.port);
}

core::Result<Address> parse_address(const std::string& ip, std::uint16_t port) {
    Address address;
    address.port = port;
    in_addr v4{};
    if (inet_pton(AF_INET, ip.c_str(), &v4) == 1) {
        map_v4(v4, address.ip);
        return address;
    }
    if (inet_pton(AF_INET6, ip.c_str(), address.ip) == 1) {
        return address;
    }
    return core::Result<Address>::failure("'" + ip +
                                          "' is neither an IPv4 nor an IPv6 address in numbers");
}

socklen_t to_socket_address(const Address& address, int family, sockaddr_storage& out) {
    if (family == AF_INET) {
        if (!address.is_v4()) {
            return 0;
        }
        sockaddr_in v4{};
        v4.sin_family = AF_INET;
        v4.sin_port = htons(address.port);
        std::memcpy(&v4.sin_addr, address.ip + kMappedPrefix.size(), 4);
        std::memcpy(&out, &v4, sizeof v4);
        return sizeof v4;
    }
    sockaddr_in6 v6{};
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(address.port);
    std::memcpy(&v6.sin6_addr, address.ip, 16);
    std::memcpy(&out, &v6, sizeof v6);
    return sizeof v6;
}

Address from_socket_address(const sockaddr_storage& in) {
    Address address;
    if (in.ss_family == AF_INET) {
        sockaddr_in v4{};
        std::memcpy(&v4, &in, sizeof v4);
        map_v4(v4.sin_addr, address.ip);
        address.port = ntohs(v4.sin_port);
    } else if (in.ss_family == AF_INET6) {
        sockaddr_in6 v6{};
        std::memcpy(&v6, &in, sizeof v6);
        std::memcpy(address.ip, &v6.sin6_addr, 16);
        address.port = ntohs(v6.sin6_port);
    }
    return address;
}

}  // namespace zoned::net
