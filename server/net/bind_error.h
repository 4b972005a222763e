// Bind error: the message for an operator when the server cannot listen on an address.
#pragma once

#include "server/net/socket_address.h"

#include <string>
#include <system_error>

namespace zoned::net {

/// A std::system_error whose text names protocol ("TCP", "UDP"), address and port, and the remedy.
[[nodiscard]] inline std::system_error bind_error(const std::error_code& error,
                                                  const std::string& protocol,
                                                  const Address& address) {
    // Asio has a category of its own, whose codes the standard's conditions do not know; on Linux
    // both hold errno.
    const std::error_code code(error.value(), std::generic_category());
    std::string hint;
    if (code == std::errc::address_in_use) {
        hint =
            "another program uses the port: stop it, or configure another port (0: any free one)";
    } else if (code == std::errc::permission_denied) {
        hint =
            "ports below 1024 need the capability CAP_NET_BIND_SERVICE: choose a higher port or "
            "grant it";
    } else if (code == std::errc::address_not_available) {
        hint = "this machine has no such address: configure one of its own, or :: for all";
    } else if (code == std::errc::address_family_not_supported) {
        hint = "this machine has no IPv6: configure 0.0.0.0 or another IPv4 address";
    } else {
        hint = "check address and port in the config";
    }
    return std::system_error(
        code, "cannot listen on " + protocol + " " + text_of(address) + " (" + hint + ")");
}

}  // namespace zoned::net
