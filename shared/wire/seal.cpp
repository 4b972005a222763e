#include "shared/wire/seal.h"

#include "shared/core/assert.h"
#include "shared/core/foreign_handle.h"
#include "shared/wire/packet.h"

#include <openssl/evp.h>

#include <algorithm>

namespace zoned::wire {
namespace {

using Context = core::Foreign<EVP_CIPHER_CTX, EVP_CIPHER_CTX_free>;

constexpr int kEncrypt = 1;
constexpr int kDecrypt = 0;

/// The key schedule is computed here, once; each datagram then only sets its nonce. nullptr:
/// OpenSSL has no memory, or does not offer AES-128-GCM.
EVP_CIPHER_CTX* make_context(const SealKey& key, int direction) {
    EVP_CIPHER_CTX* const context = EVP_CIPHER_CTX_new();
    if (context != nullptr &&
        EVP_CipherInit_ex(
            context, EVP_aes_128_gcm(), nullptr, key.key.data(), nullptr, direction) == 1) {
        return context;
    }
    EVP_CIPHER_CTX_free(context);
    return nullptr;
}

}  // namespace

struct Seal::Contexts {
    explicit Contexts(const SealKey& key)
        : encrypt(make_context(key, kEncrypt)),
          decrypt(make_context(key, kDecrypt)),
          salt(key.salt) {}

    Context encrypt;
    Context decrypt;
    std::array<std::uint8_t, 12> salt;

    /// Salt XOR the sequence as a big-endian number on the right (RFC 8446, section 5.3).
    [[nodiscard]] std::array<std::uint8_t, 12> nonce(std::uint64_t sequence) const {
        std::array<std::uint8_t, 12> n = salt;
        for (std::size_t i = 0; i < 8; ++i) {
            n[11 - i] = static_cast<std::uint8_t>(n[11 - i] ^ (sequence >> (8 * i)));
        }
        return n;
    }
};

Seal::Seal(const SealKey& key) : contexts_(std::make_unique<Contexts>(key)) {
}

Seal::Seal() = default;

Seal Seal::none() {
    return {};
}

bool Seal::usable() const {
    return !contexts_ ||
           (contexts_->encrypt.get() != nullptr && contexts_->decrypt.get() != nullptr);
}

Seal::Seal(Seal&&) noexcept = default;
Seal& Seal::operator=(Seal&&) noexcept = default;
Seal::~Seal() = default;

void Seal::seal(std::uint64_t sequence,
                std::span<const std::uint8_t> associated,
                std::span<const std::uint8_t> plain,
                std::vector<std::uint8_t>& out) {
    if (!contexts_) {
        out.insert(out.end(), plain.begin(), plain.end());
        out.resize(out.size() + kSealTagBytes);
        return;
    }
    EVP_CIPHER_CTX* context = contexts_->encrypt.get();
    const std::array<std::uint8_t, 12> nonce = contexts_->nonce(sequence);
    const std::size_t at = out.size();
    out.resize(at + plain.size() + kSealTagBytes);
    std::uint8_t* p = out.data() + at;
    int written = 0;
    bool ok = context != nullptr &&
              EVP_CipherInit_ex(context, nullptr, nullptr, nullptr, nonce.data(), -1) == 1;
    ok = ok &&
         (associated.empty() ||
          EVP_CipherUpdate(
              context, nullptr, &written, associated.data(), static_cast<int>(associated.size())) ==
              1);
    ok = ok && (plain.empty() ||
                EVP_CipherUpdate(
                    context, p, &written, plain.data(), static_cast<int>(plain.size())) == 1);
    ok = ok && EVP_CipherFinal_ex(context, p + plain.size(), &written) == 1;
    ok =
        ok &&
        EVP_CIPHER_CTX_ctrl(
            context, EVP_CTRL_AEAD_GET_TAG, static_cast<int>(kSealTagBytes), p + plain.size()) == 1;
    ZONED_ASSERT(ok, "a usable seal cannot fail at a datagram of sane size");
}

bool Seal::open(std::uint64_t sequence,
                std::span<const std::uint8_t> associated,
                std::span<const std::uint8_t> sealed,
                std::vector<std::uint8_t>& plain) {
    plain.clear();
    if (sealed.size() < kSealTagBytes) {
        return false;
    }
    if (!contexts_) {
        const auto tag = sealed.end() - static_cast<std::ptrdiff_t>(kSealTagBytes);
        if (std::any_of(tag, sealed.end(), [](std::uint8_t byte) { return byte != 0; })) {
            return false;
        }
        plain.assign(sealed.begin(), tag);
        return true;
    }
    EVP_CIPHER_CTX* context = contexts_->decrypt.get();
    const std::array<std::uint8_t, 12> nonce = contexts_->nonce(sequence);
    const std::size_t size = sealed.size() - kSealTagBytes;
    // OpenSSL takes the expected tag through a pointer to non-const.
    std::array<std::uint8_t, kSealTagBytes> tag{};
    std::copy(sealed.begin() + static_cast<std::ptrdiff_t>(size), sealed.end(), tag.begin());
    plain.resize(size);
    int written = 0;
    bool ok = context != nullptr &&
              EVP_CipherInit_ex(context, nullptr, nullptr, nullptr, nonce.data(), -1) == 1;
    ok =
        ok && EVP_CIPHER_CTX_ctrl(
                  context, EVP_CTRL_AEAD_SET_TAG, static_cast<int>(kSealTagBytes), tag.data()) == 1;
    ok = ok &&
         (associated.empty() ||
          EVP_CipherUpdate(
              context, nullptr, &written, associated.data(), static_cast<int>(associated.size())) ==
              1);
    ok = ok && (size == 0 ||
                EVP_CipherUpdate(
                    context, plain.data(), &written, sealed.data(), static_cast<int>(size)) == 1);
    std::array<std::uint8_t, kSealTagBytes> rest{};
    ok = ok && EVP_CipherFinal_ex(context, rest.data(), &written) == 1;
    if (!ok) {
        plain.clear();
    }
    return ok;
}

}  // namespace zoned::wire
