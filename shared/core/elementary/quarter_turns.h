// Quarter turns: cuts angles into whole quarters and a rest, exact enough for any angle.
#pragma once

#include <cstdint>

namespace zoned::elementary {

/// angle = quarter pi / 2 + high + low, quarter taken modulo 4; |high| is at most pi / 4 and a
/// little, |low| half a unit in the last place of it and less.
struct QuarterTurns {
    std::uint32_t quarter = 0;
    double high = 0.0;
    double low = 0.0;
};

/// Up to this angle few parts of pi / 2 suffice: a whole number of quarters has 20 bits.
inline constexpr double kFewQuarters = 0x1p20;

/// The nearest whole number, ties to even, of a number below 2^51 in magnitude: in the sum nothing
/// is left of its fraction.
inline double nearest_whole(double x) {
    constexpr double kShift = 0x1.8p52;
    return (x + kShift) - kShift;
}

/// Of a whole number below 2^31 in magnitude.
inline std::uint32_t modulo_four(double whole) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(whole)) & 3U;
}

/// To 2^-66 of the rest. `angle` is finite.
QuarterTurns quarter_turns(double angle);

/// For |angle| < kFewQuarters: the rest alone, to 2^-40 of itself for angles that are floats.
inline QuarterTurns few_quarter_turns(double angle) {
    constexpr double kQuartersPerRadian = 0x1.45f306dc9c883p-1;
    constexpr double kFirst = 0x1.921fb54400000p+0;  // 33 bits of pi / 2: products are exact
    constexpr double kRest = 0x1.0b4611a626331p-34;
    const double whole = nearest_whole(angle * kQuartersPerRadian);
    return {modulo_four(whole), (angle - whole * kFirst) - whole * kRest, 0.0};
}

}  // namespace zoned::elementary
