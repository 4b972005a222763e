// Seal: authenticated encryption of datagrams, AES-128-GCM (RFC 5116), one context per direction.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::wire {

/// Random key and nonce salt of one direction, which Welcome tells. Each copy is wiped at its end.
struct SealKey {
    static constexpr std::size_t kBytes = 28;  ///< key (16), then salt (12)

    SealKey() = default;
    SealKey(const SealKey&) = default;
    SealKey& operator=(const SealKey&) = default;

    ~SealKey() {
        // Volatile: a compiler leaves out writes to what is about to end.
        const auto wipe = [](volatile std::uint8_t* bytes, std::size_t count) {
            std::fill_n(bytes, count, std::uint8_t{0});
        };
        wipe(key.data(), key.size());
        wipe(salt.data(), salt.size());
    }

    /// As Welcome tells it.
    [[nodiscard]] std::string bytes() const {
        std::string out(key.begin(), key.end());
        out.append(salt.begin(), salt.end());
        return out;
    }

    /// Nothing where it has another length.
    [[nodiscard]] static std::optional<SealKey> from(std::string_view bytes) {
        if (bytes.size() != kBytes) {
            return std::nullopt;
        }
        SealKey out;
        std::copy_n(bytes.begin(), out.key.size(), out.key.begin());
        std::copy_n(bytes.begin() + out.key.size(), out.salt.size(), out.salt.begin());
        return out;
    }

    std::array<std::uint8_t, 16> key{};
    std::array<std::uint8_t, 12> salt{};
};

/// Seals or opens datagrams with one key. The nonce is the salt XOR the 64-bit sequence, as in
/// TLS 1.3: a sequence must never be sealed twice under one key. Not thread-safe; no allocation
/// after construction.
class Seal {
  public:
    explicit Seal(const SealKey& key);

    /// False: the cryptography library does not offer what a seal needs. Nothing must be sealed
    /// then, and nothing opens.
    [[nodiscard]] bool usable() const;

    /// Passes datagrams on as they are, with 16 zero bytes for a tag. Only for a stream that
    /// protects what it carries: such datagrams must never be taken from UDP.
    static Seal none();
    Seal(Seal&&) noexcept;
    Seal& operator=(Seal&&) noexcept;
    ~Seal();

    /// Appends ciphertext and 16-byte tag of `plain` to `out`; `associated` is authenticated, not
    /// encrypted.
    void seal(std::uint64_t sequence,
              std::span<const std::uint8_t> associated,
              std::span<const std::uint8_t> plain,
              std::vector<std::uint8_t>& out);

    /// Replaces `plain` by the opened text; false (and `plain` empty) when it does not
    /// authenticate.
    bool open(std::uint64_t sequence,
              std::span<const std::uint8_t> associated,
              std::span<const std::uint8_t> sealed,
              std::vector<std::uint8_t>& plain);

  private:
    struct Contexts;
    Seal();

    std::unique_ptr<Contexts> contexts_;  // null: none()
};

/// Sliding window against replay (RFC 4303, section 3.4.3), 1,024 sequences wide.
class ReplayWindow {
  public:
    /// True when `sequence` was neither seen nor is too old. Does not change the window.
    [[nodiscard]] bool fresh(std::uint64_t sequence) const;
    /// Marks a sequence that authenticated.
    void mark(std::uint64_t sequence);

    [[nodiscard]] std::uint64_t newest() const { return newest_; }

  private:
    static constexpr std::size_t kWords = 16;
    std::array<std::uint64_t, kWords> seen_{};
    std::uint64_t newest_ = 0;
};

}  // namespace zoned::wire
