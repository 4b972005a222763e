// Socket address: converts addresses between their text, socket and byte forms.
#pragma once

#include "server/mailbox/address.h"
#include "shared/core/result.h"

#include <sys/socket.h>

#include <cstdint>
#include <string>

namespace zoned::net {

using mailbox::Address;

/// "127.0.0.1:80" or "[::1]:80".
[[nodiscard]] std::string text_of(const Address& address);

/// From a numeric address; fails with a clear text on anything else (names are not looked up).
[[nodiscard]] core::Result<Address> parse_address(const std::string& ip, std::uint16_t port);

/// `family` is the socket's: AF_INET takes v4-mapped addresses only (returns 0 for others). Returns
/// the length written.
[[nodiscard]] socklen_t to_socket_address(const Address& address,
                                          int family,
                                          sockaddr_storage& out);

/// From the kernel's address; addresses of other families become all zero.
[[nodiscard]] Address from_socket_address(const sockaddr_storage& in);

}  // namespace zoned::net
