// Ports: let one walk over a packet's decisions serve encoder and decoder. An encoder's port writes
// the given value; a decoder's port ignores it and reads one.
#pragma once

#include "shared/wire/entropy/residual_model.h"

#include <cstdint>

namespace zoned::wire::entropy {

/// Writes.
struct EncodePort {
    static constexpr bool kDecodes = false;

    RangeEncoder& coder;

    bool bit(const BitModel& model, bool value) {
        model.encode(coder, value);
        return value;
    }

    int symbol(const SymbolModel& model, int value) {
        model.encode(coder, value);
        return value;
    }

    /// The raw rest of a magnitude whose symbol was coded.
    std::uint32_t magnitude(std::uint32_t value, int /*symbol*/) {
        encode_rest(coder, magnitude_of(value));
        return value;
    }

    std::uint32_t raw(std::uint32_t value, int bits) {
        coder.encode_raw(value, bits);
        return value;
    }
};

/// Reads.
struct DecodePort {
    static constexpr bool kDecodes = true;

    RangeDecoder& coder;

    bool bit(const BitModel& model, bool /*value*/) { return model.decode(coder); }

    int symbol(const SymbolModel& model, int /*value*/) { return model.decode(coder); }

    std::uint32_t magnitude(std::uint32_t /*value*/, int symbol) {
        return decode_magnitude(coder, symbol);
    }

    std::uint32_t raw(std::uint32_t /*value*/, int bits) { return coder.decode_raw(bits); }
};

/// A residual by a model, which may learn `symbol` then. Its magnitude is at most kMaxResidual,
/// whatever is read.
template <class Port>
std::int32_t code_residual(Port& port, const SymbolModel& model, std::int32_t value, int& symbol) {
    const auto size = static_cast<std::uint32_t>(value < 0 ? -value : value);
    symbol = port.symbol(model, magnitude_of(size).symbol);
    const auto result = static_cast<std::int32_t>(port.magnitude(size, symbol));
    return result != 0 && port.raw(value < 0 ? 1 : 0, 1) != 0 ? -result : result;
}

}  // namespace zoned::wire::entropy
