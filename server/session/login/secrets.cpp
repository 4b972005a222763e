#include "server/session/login/secrets.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/rand.h>

#include <stdexcept>

namespace zoned::session {

void random_bytes(std::span<std::uint8_t> out) {
    if (RAND_bytes(out.data(), static_cast<int>(out.size())) != 1) {
        throw std::runtime_error("the random source of the system gives no numbers");
    }
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

std::uint64_t hash_prefix(std::span<const std::uint8_t> secret) {
    std::array<std::uint8_t, EVP_MAX_MD_SIZE> digest{};
    if (EVP_Digest(secret.data(), secret.size(), digest.data(), nullptr, EVP_sha256(), nullptr) !=
        1) {
        throw std::runtime_error("SHA-256 is not available");
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 8; ++i) {
        value = (value << 8) | digest[i];
    }
    return value;
}

std::string to_hex(std::span<const std::uint8_t> bytes) {
    constexpr char kDigits[] = "0123456789abcdef";
    std::string out;
    out.reserve(bytes.size() * 2);
    for (const std::uint8_t b : bytes) {
        out.push_back(kDigits[b >> 4]);
        out.push_back(kDigits[b & 15]);
    }
    return out;
}

namespace {

int digit_of(char c) {
    if (c >= '0' && c <= '9') {
        return c - '0';
    }
    if (c >= 'a' && c <= 'f') {
        return c - 'a' + 10;
    }
    if (c >= 'A' && c <= 'F') {
        return c - 'A' + 10;
    }
    return -1;
}

}  // namespace

core::Result<std::array<std::uint8_t, 32>> parse_key_hex(std::string_view text) {
    using Key = std::array<std::uint8_t, 32>;
    constexpr std::string_view kSpace = " \t\r\n";
    const std::size_t first = text.find_first_not_of(kSpace);
    if (first == std::string_view::npos) {
        return core::Result<Key>::failure("the key is empty; it should be 64 hexadecimal digits");
    }
    text = text.substr(first, text.find_last_not_of(kSpace) - first + 1);
    if (text.size() != 64) {
        return core::Result<Key>::failure("the key has " + std::to_string(text.size()) +
                                          " characters; it should be 64 hexadecimal digits");
    }
    Key key{};
    for (std::size_t i = 0; i < key.size(); ++i) {
        const int high = digit_of(text[2 * i]);
        const int low = digit_of(text[2 * i + 1]);
        if (high < 0 || low < 0) {
            return core::Result<Key>::failure(
                "the key holds a character that is no hexadecimal "
                "digit near position " +
                std::to_string(2 * i + 1));
        }
        key[i] = static_cast<std::uint8_t>(high * 16 + low);
    }
    return key;
}

}  // namespace zoned::session
