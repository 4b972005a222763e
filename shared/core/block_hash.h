// BlockHash: hashes many numbers into one word, faster than a single chain; for records that enter
// a StateHash.
#pragma once

#include "shared/core/rng.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace zoned::core {

/// Words enter four chains in turn, which the processor works on side by side. Each step of a
/// chain is a bijection, so that records of one kind which differ in one number have different
/// values but for one pair in 2^64. Not cryptographic.
class BlockHash {
  public:
    [[gnu::always_inline]] void add(std::uint64_t word) {
        std::uint64_t& chain = chains_[count_++ % kChains];
        chain = (chain ^ word) * 0x9E3779B97F4A7C15ull;
        chain ^= chain >> 29U;
    }

    /// Hashes a float by its bits, with -0.0 kept apart from +0.0.
    [[gnu::always_inline]] void add(float f) {
        add(static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(f)));
    }

    template <class T>
        requires std::is_integral_v<T>

    [[gnu::always_inline]] void add(T number) {
        add(static_cast<std::uint64_t>(number));
    }

    /// Packs a small number into a word shared with its neighbours, which takes fewer steps.
    /// Records of one kind must pack the same types in the same order.
    template <class T>
    [[gnu::always_inline]] void pack(T number) {
        constexpr unsigned kBits = 8U * sizeof(T);
        if (packed_bits_ + kBits > 64U) {
            flush();
        }
        packed_ |= bits_of(number) << packed_bits_;
        packed_bits_ += kBits;
    }

    /// Hash of all numbers added and packed so far.
    [[nodiscard]] std::uint64_t value() const {
        if (packed_bits_ > 0) {
            BlockHash whole = *this;
            whole.flush();
            return whole.value();
        }
        std::uint64_t value = count_;
        for (const std::uint64_t chain : chains_) {
            value = mix(value ^ chain) + 0x9E3779B97F4A7C15ull;
        }
        return value;
    }

  private:
    static constexpr std::size_t kChains = 4;

    [[gnu::always_inline]] static std::uint64_t bits_of(float f) {
        return std::bit_cast<std::uint32_t>(f);
    }

    template <class T>
        requires(std::is_integral_v<T> || std::is_enum_v<T>)

    [[gnu::always_inline]] static std::uint64_t bits_of(T number) {
        // As many bits as the type has, whatever its sign.
        constexpr unsigned kUnused = 64U - 8U * sizeof(T);
        return static_cast<std::uint64_t>(number) << kUnused >> kUnused;
    }

    [[gnu::always_inline]] void flush() {
        add(packed_);
        packed_ = 0;
        packed_bits_ = 0;
    }

    std::array<std::uint64_t, kChains> chains_{0x6A09E667F3BCC908ull,
                                               0xBB67AE8584CAA73Bull,
                                               0x3C6EF372FE94F82Bull,
                                               0xA54FF53A5F1D36F1ull};
    std::size_t count_ = 0;
    std::uint64_t packed_ = 0;
    unsigned packed_bits_ = 0;
};

}  // namespace zoned::core
