// StateHash: a running 64-bit hash over simulation state, to compare runs bit for bit.
#pragma once

#include "shared/core/rng.h"

#include <bit>
#include <cstdint>
#include <span>
#include <type_traits>

namespace zoned::core {

/// Order-sensitive hash over words. Not cryptographic: it finds differences, it does not resist
/// forgery. Float values enter by their bits, with -0.0 kept apart from +0.0 on purpose.
class StateHash {
  public:
    void add(std::uint64_t word) { value_ = mix(value_ ^ word) + 0x9E3779B97F4A7C15ull; }

    void add(float f) { add(static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(f))); }

    void add(double d) { add(std::bit_cast<std::uint64_t>(d)); }

    template <class T>
        requires std::is_integral_v<T>

    void add(T word) { add(static_cast<std::uint64_t>(word)); }

    void add_bytes(std::span<const std::uint8_t> bytes) {
        add(static_cast<std::uint64_t>(bytes.size()));
        std::uint64_t word = 0;
        unsigned filled = 0;
        for (const std::uint8_t b : bytes) {
            word |= static_cast<std::uint64_t>(b) << (8 * filled);
            if (++filled == 8) {
                add(word);
                word = 0;
                filled = 0;
            }
        }
        if (filled != 0) {
            add(word);
        }
    }

    [[nodiscard]] std::uint64_t value() const { return value_; }

  private:
    std::uint64_t value_ = 0x6A09E667F3BCC908ull;
};

}  // namespace zoned::core
