// Byte order: whole numbers as little-endian bytes, for the byte-aligned parts of a datagram.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

namespace zoned::wire {

/// Writes the sizeof(T) bytes of `value`, low byte first.
template <std::unsigned_integral T>
void store_le(T value, std::uint8_t* out) {
    for (std::size_t i = 0; i < sizeof(T); ++i) {
        out[i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
}

/// Reads sizeof(T) bytes, low byte first.
template <std::unsigned_integral T>
T load_le(const std::uint8_t* in) {
    T value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
        value = static_cast<T>(value | static_cast<T>(static_cast<T>(in[i]) << (8 * i)));
    }
    return value;
}

}  // namespace zoned::wire
