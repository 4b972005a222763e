// Residual models: code the error of a prediction, in whole steps, by its expected magnitude.
#pragma once

#include "shared/wire/entropy/symbol_model.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace zoned::wire::entropy {

/// Expected magnitudes fall into classes of half an octave (two to an octave, the upper one half as
/// large again): class 0 is [0, 0.5), 1 is [0.5, 1), 2 is [1, 2), 3 is [2, 3), ...
inline constexpr int kScaleClasses = 28;

/// The class of an expected magnitude in steps; negative ones count as 0, not a number as the
/// largest. Exact: the same bits give the same class everywhere.
inline int scale_class(float expected) {
    if (!(expected > 0.0F)) {
        return expected <= 0.0F ? 0 : kScaleClasses - 1;
    }
    // The exponent and the first bit behind it of 1 + expected.
    const auto bits = std::bit_cast<std::uint32_t>(1.0F + expected);
    const int scale = static_cast<int>(bits >> 22) - (127 << 1);
    return std::min(scale, kScaleClasses - 1);
}

/// The largest magnitude that a residual may have.
inline constexpr std::int32_t kMaxResidual = (1 << 24) - 1;

/// A magnitude as a symbol and as many raw bits as its class leaves open: 0, 1, 2 and 3 have a
/// symbol each, then two to an octave up to 191; a greater magnitude codes its octave in four bits.
struct Magnitude {
    int symbol = 0;
    int open_bits = 0;       ///< of the class
    std::uint32_t open = 0;  ///< which of the class's magnitudes it is
};

inline constexpr int kEscapeSymbol = 15;
inline constexpr std::uint32_t kEscapeFrom = 192;

inline Magnitude magnitude_of(std::uint32_t value) {
    if (value < 4) {
        return {static_cast<int>(value), 0, 0};
    }
    if (value >= kEscapeFrom) {
        return {kEscapeSymbol, 0, value - kEscapeFrom};
    }
    const int octave = std::bit_width(value) - 1;
    const int open_bits = octave - 1;
    const int half = static_cast<int>(value >> open_bits) & 1;
    return {4 + 2 * (octave - 2) + half, open_bits, value & ((1u << open_bits) - 1)};
}

/// About the middle of a symbol's magnitudes.
float typical_magnitude(int symbol);

/// One model per class of expectation. To begin with residuals are taken for two-sided geometric
/// ones of that mean magnitude (the discrete Laplace distribution of prediction errors: P. G.
/// Howard and J. S. Vitter, "Fast and efficient lossless image compression", DCC 1993, section 4).
class ResidualModel {
  public:
    ResidualModel();

    [[nodiscard]] const SymbolModel& of(int scale) const {
        return models_[static_cast<std::size_t>(scale)];
    }

    [[nodiscard]] SymbolModel& of(int scale) { return models_[static_cast<std::size_t>(scale)]; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(models_);
    }

  private:
    std::array<SymbolModel, kScaleClasses> models_;
};

/// The raw part of a magnitude without a sign: open bits, escape. `symbol` has been coded before.
void encode_rest(RangeEncoder& coder, const Magnitude& magnitude);
std::uint32_t decode_magnitude(RangeDecoder& coder, int symbol);

}  // namespace zoned::wire::entropy
