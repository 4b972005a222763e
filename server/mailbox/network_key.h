// NetworkKey: the network of an address, of which its users may be taken to be one party.
#pragma once

#include "server/mailbox/address.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace zoned::mailbox {

using NetworkKey = std::array<std::uint8_t, 16>;

/// An IPv4 address, or the first 64 bits of an IPv6 address (a home's line has a network of that
/// size, RFC 6177).
inline NetworkKey network_of(const Address& address) {
    NetworkKey key{};
    std::copy_n(address.ip, address.is_v4() ? 16 : 8, key.begin());
    return key;
}

}  // namespace zoned::mailbox
