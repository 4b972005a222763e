#include "shared/wire/entropy/residual_model.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace zoned::wire::entropy {

namespace {

/// The smallest magnitude of a symbol; for the index after the last, the end of escapes.
constexpr std::uint32_t first_magnitude(int symbol) {
    if (symbol < 4) {
        return static_cast<std::uint32_t>(symbol);
    }
    const int octave = 2 + (symbol - 4) / 2;
    return (symbol % 2 == 0 ? 2u : 3u) << (octave - 1);
}

/// Most raw bits coded at a time in an escape.
constexpr int kLowerBits = 12;

constexpr int open_bits_of(int symbol) {
    return symbol < 4 ? 0 : 1 + (symbol - 4) / 2;
}

static_assert(first_magnitude(kEscapeSymbol) == kEscapeFrom);

/// The middle of a class of expectation.
double expectation_of(int scale) {
    const double octave = static_cast<double>(1u << (scale / 2));
    return octave * (scale % 2 == 0 ? 1.25 : 1.75) - 1.0;
}

/// theta^n by whole multiplications: the same bits everywhere.
double power(double theta, std::uint32_t n) {
    double result = 1.0;
    for (double square = theta; n != 0; n >>= 1, square *= square) {
        if ((n & 1u) != 0) {
            result *= square;
        }
    }
    return result;
}

}  // namespace

ResidualModel::ResidualModel() {
    for (int scale = 0; scale < kScaleClasses; ++scale) {
        const double mean = expectation_of(scale);
        // The mean magnitude of theta^|r| (1 - theta) / (1 + theta) is 2 theta / (1 - theta^2).
        const double theta = (std::sqrt(1.0 + mean * mean) - 1.0) / mean;
        std::array<std::uint32_t, SymbolModel::kSymbols> weights;
        for (int symbol = 0; symbol < SymbolModel::kSymbols; ++symbol) {
            const double from =
                symbol == 0 ? 1.0 : 2.0 * power(theta, first_magnitude(symbol)) / (1.0 + theta);
            const double to = symbol == kEscapeSymbol
                                  ? 0.0
                                  : 2.0 * power(theta, first_magnitude(symbol + 1)) / (1.0 + theta);
            weights[static_cast<std::size_t>(symbol)] =
                1 + static_cast<std::uint32_t>(60000.0 * std::max(0.0, from - to));
        }
        of(scale).set(weights);
    }
}

float typical_magnitude(int symbol) {
    const std::uint32_t first = first_magnitude(symbol);
    const std::uint32_t next = symbol == kEscapeSymbol ? 2 * first : first_magnitude(symbol + 1);
    return 0.5F * static_cast<float>(first + next - 1);
}

void encode_rest(RangeEncoder& coder, const Magnitude& magnitude) {
    if (magnitude.symbol != kEscapeSymbol) {
        coder.encode_raw(magnitude.open, magnitude.open_bits);
        return;
    }
    const std::uint32_t over = magnitude.open + 1;
    const int octave = std::bit_width(over) - 1;
    const int upper_bits = std::max(0, octave - kLowerBits);
    const std::uint32_t low = over - (1u << octave);
    coder.encode_raw(static_cast<std::uint32_t>(octave), 5);
    coder.encode_raw(low >> (octave - upper_bits), upper_bits);
    coder.encode_raw(low & ((1u << (octave - upper_bits)) - 1), octave - upper_bits);
}

std::uint32_t decode_magnitude(RangeDecoder& coder, int symbol) {
    if (symbol < kEscapeSymbol) {
        return first_magnitude(symbol) + coder.decode_raw(open_bits_of(symbol));
    }
    const int octave = std::min(static_cast<int>(coder.decode_raw(5)), 24);
    const int upper_bits = std::max(0, octave - kLowerBits);
    const std::uint32_t upper = coder.decode_raw(upper_bits);
    const std::uint32_t lower = coder.decode_raw(octave - upper_bits);
    const std::uint32_t over = (1u << octave) + (upper << (octave - upper_bits)) + lower;
    return std::min<std::uint32_t>(over - 1 + kEscapeFrom, kMaxResidual);
}

}  // namespace zoned::wire::entropy
