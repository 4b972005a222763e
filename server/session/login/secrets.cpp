#include "server/session/login/secrets.h"

#include "shared/core/hex.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/rand.h>

#include <algorithm>
#include <stdexcept>

namespace zoned::session {

void random_bytes(std::span<std::uint8_t> out) {
    if (RAND_bytes(out.data(), static_cast<int>(out.size())) != 1) {
        throw std::runtime_error("the random source of the system gives no numbers");
    }
}

wire::SealKey random_key() {
    wire::SealKey key;
    random_bytes(key.key);
    random_bytes(key.salt);
    return key;
}

std::uint32_t random_nonzero_u32() {
    for (;;) {
        std::array<std::uint8_t, 4> b{};
        random_bytes(b);
        const std::uint32_t value =
            static_cast<std::uint32_t>(b[0]) | (static_cast<std::uint32_t>(b[1]) << 8) |
            (static_cast<std::uint32_t>(b[2]) << 16) | (static_cast<std::uint32_t>(b[3]) << 24);
        if (value != 0) {
            return value;
        }
    }
}

bool equal_in_constant_time(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
    return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::array<std::uint8_t, 32> sha256(std::span<const std::uint8_t> bytes) {
    std::array<std::uint8_t, 32> digest{};
    if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), nullptr, EVP_sha256(), nullptr) !=
        1) {
        throw std::runtime_error("SHA-256 is not available");
    }
    return digest;
}

core::Result<std::array<std::uint8_t, 32>> parse_key_hex(std::string_view text) {
    using Key = std::array<std::uint8_t, 32>;
    constexpr std::string_view kSpace = " \t\r\n";
    const std::size_t first = text.find_first_not_of(kSpace);
    if (first != std::string_view::npos) {
        text = text.substr(first, text.find_last_not_of(kSpace) - first + 1);
    }
    const auto bytes = core::from_hex(text);
    Key key{};
    if (!bytes || bytes->size() != key.size()) {
        return core::Result<Key>::failure(
            "64 hexadecimal digits are expected, as zoned keygen writes them");
    }
    std::copy(bytes->begin(), bytes->end(), key.begin());
    return key;
}

}  // namespace zoned::session
