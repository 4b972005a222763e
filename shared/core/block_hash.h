// BlockHash: many numbers into one word, faster than a chain of as many; for records that enter a
// StateHash.
#pragma once

#include "shared/core/rng.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace zoned::core {

/// Numbers are packed, and every four words enter four chains, which the processor works on side by
/// side. Each step of a chain is a bijection, so that records of one kind which differ in one
/// number have different values but for one in 2^64. Not cryptographic.
class BlockHash {
  public:
    /// By its bits, with -0.0 kept apart from +0.0.
    void add(float f) { put(std::bit_cast<std::uint32_t>(f)); }

    template <class T>
        requires std::is_integral_v<T>

    void add(T number) {
        const auto word = static_cast<std::uint64_t>(number);
        put(static_cast<std::uint32_t>(word));
        if constexpr (sizeof(T) > sizeof(std::uint32_t)) {
            put(static_cast<std::uint32_t>(word >> 32U));
        }
    }

    /// Of all that was added so far; afterwards nothing more may be.
    [[nodiscard]] std::uint64_t value() {
        const std::size_t count = taken_ + size_;
        while (size_ % kAtOnce != 0) {
            halves_[size_++] = 0;
        }
        take();
        std::uint64_t value = count;
        for (const std::uint64_t chain : chains_) {
            value = mix(value ^ chain) + 0x9E3779B97F4A7C15ull;
        }
        return value;
    }

  private:
    static constexpr std::size_t kChains = 4;
    static constexpr std::size_t kAtOnce = 2 * kChains;  ///< halves of words
    static constexpr std::size_t kHalves = 32 * kAtOnce;

    [[gnu::always_inline]] void put(std::uint32_t half) {
        halves_[size_++] = half;
        if (size_ == kHalves) {
            take();
        }
    }

    void take() {
        for (std::size_t i = 0; i < size_; i += kAtOnce) {
            std::array<std::uint64_t, kChains> words;
            std::memcpy(words.data(), &halves_[i], sizeof(words));
            for (std::size_t c = 0; c < kChains; ++c) {
                chains_[c] = (chains_[c] ^ words[c]) * 0x9E3779B97F4A7C15ull;
                chains_[c] ^= chains_[c] >> 29U;
            }
        }
        taken_ += size_;
        size_ = 0;
    }

    std::array<std::uint32_t, kHalves> halves_;
    std::array<std::uint64_t, kChains> chains_{0x6A09E667F3BCC908ull,
                                               0xBB67AE8584CAA73Bull,
                                               0x3C6EF372FE94F82Bull,
                                               0xA54FF53A5F1D36F1ull};
    std::size_t size_ = 0;
    std::size_t taken_ = 0;
};

}  // namespace zoned::core
