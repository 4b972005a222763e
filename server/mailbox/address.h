// Address: IPv6 or v4-mapped address and port of a client, as plain bytes.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>

namespace zoned::mailbox {

/// IPv4 addresses are v4-mapped (RFC 4291, section 2.5.5.2). Test harnesses invent their own.
struct Address {
    static constexpr std::array<std::uint8_t, 12> kMappedPrefix =
        {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};

    std::uint8_t ip[16] = {};
    std::uint16_t port = 0;

    [[nodiscard]] bool is_v4() const {
        return std::equal(kMappedPrefix.begin(), kMappedPrefix.end(), ip);
    }

    [[nodiscard]] bool is_loopback() const {
        return is_v4()
                   ? ip[12] == 127
                   : std::all_of(ip, ip + 15, [](std::uint8_t b) { return b == 0; }) && ip[15] == 1;
    }

    friend auto operator<=>(const Address&, const Address&) = default;
};

}  // namespace zoned::mailbox
