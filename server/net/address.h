// Address: IPv6 or v4-mapped address and port, as plain bytes; text and socket forms of it.
#pragma once

#include "shared/core/result.h"

#include <sys/socket.h>

#include <compare>
#include <cstdint>
#include <string>

namespace zoned::net {

/// IPv4 addresses are v4-mapped (RFC 4291, section 2.5.5.2).
struct Address {
    std::uint8_t ip[16] = {};
    std::uint16_t port = 0;

    [[nodiscard]] bool is_v4() const;
    [[nodiscard]] bool is_loopback() const;
    /// "127.0.0.1:80" or "[::1]:80".
    [[nodiscard]] std::string text() const;

    friend auto operator<=>(const Address&, const Address&) = default;
};

/// From a numeric address; fails with a clear text on anything else (names are not looked up).
[[nodiscard]] core::Result<Address> parse_address(const std::string& ip, std::uint16_t port);

/// `family` is the socket's: AF_INET takes v4-mapped addresses only (returns 0 for others). Returns
/// the length of what was written.
[[nodiscard]] socklen_t to_socket_address(const Address& address,
                                          int family,
                                          sockaddr_storage& out);

/// From what the kernel says; addresses of other families become all zero.
[[nodiscard]] Address from_socket_address(const sockaddr_storage& in);

}  // namespace zoned::net
