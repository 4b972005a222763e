// Trust: how a client makes sure that it talks to the right server.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::link {

struct Trust {
    enum class TrustKind : std::uint8_t {
        kPin,       ///< the certificate's SHA-256 must be `pin`
        kInsecure,  ///< anyone; for development on loopback addresses
        kVerify,    ///< chain and host name against the certificate authorities
    } kind = TrustKind::kVerify;
    std::vector<std::uint8_t> pin;  ///< 32 bytes
    std::string host;               ///< name to verify and to send as server name
};

}  // namespace zoned::link
