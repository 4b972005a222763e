#include "shared/core/elementary/quarter_turns.h"

#include <array>
#include <bit>
#include <cmath>

namespace zoned::elementary {

namespace {

__extension__ using Wide = unsigned __int128;

/// 64 zeros, then the bits of 2 / pi behind the point.
constexpr std::array<std::uint64_t, 21> kTwoOverPi = {
    0x0000000000000000, 0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041,
    0xfe5163abdebbc561, 0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e,
    0xe88235f52ebb4484, 0xe99c7026b45f7e41, 0x3991d639835339f4, 0x9c845f8bbdf9283b,
    0x1ff897ffde05980f, 0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7, 0x4f463f669e5fea2d,
    0x7527bac7ebe5f17b, 0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab,
    0xf0cfbc209af4361d};

/// sum + rest = a + b exactly (D. Knuth, "The Art of Computer Programming", vol. 2, 4.2.2).
struct ExactSum {
    double sum;
    double rest;
};

ExactSum exact_sum(double a, double b) {
    const double sum = a + b;
    const double b_share = sum - a;
    const double a_share = sum - b_share;
    return {sum, (a - a_share) + (b - b_share)};
}

/// Three products of 20 and 33 bits are exact, and so is the first difference; what is left of
/// pi / 2 behind them is below 2^-155 of it.
QuarterTurns by_parts(double angle) {
    constexpr double kQuartersPerRadian = 0x1.45f306dc9c883p-1;
    constexpr std::array<double, 4> kParts = {
        0x1.921fb54400000p+0, 0x1.0b4611a600000p-34, 0x1.3198a2e000000p-69, 0x1.b839a252049c1p-104};
    const double whole = nearest_whole(angle * kQuartersPerRadian);
    const ExactSum first = exact_sum(angle - whole * kParts[0], -(whole * kParts[1]));
    const ExactSum second = exact_sum(first.rest, -(whole * kParts[2]));
    const ExactSum both = exact_sum(first.sum, second.sum);
    const double tail = both.rest + (second.rest - whole * kParts[3]);
    const ExactSum out = exact_sum(both.sum, tail);
    return {modulo_four(whole), out.sum, out.rest};
}

/// angle = m 2^e with 53 bits in m. Bits of 2 / pi that make products of whole turns are left out;
/// 192 bits from there on give m 2^e 2 / pi modulo 4 to 2^-137. No double is nearer to a multiple
/// of pi / 2 than 2^-62 (Muller, chapter 11).
QuarterTurns by_window(double angle) {
    const auto bits = std::bit_cast<std::uint64_t>(std::abs(angle));
    const std::uint64_t m = (bits & ((1ULL << 52) - 1)) | (1ULL << 52);
    const int e = static_cast<int>(bits >> 52) - 1075;
    const auto begin = static_cast<std::size_t>(e - 2 + 64);
    const std::size_t word = begin / 64;
    const std::size_t shift = begin % 64;
    std::array<std::uint64_t, 3> window{};
    for (std::size_t i = 0; i < 3; ++i) {
        const std::uint64_t high = kTwoOverPi[word + i];
        const std::uint64_t low = kTwoOverPi[word + i + 1];
        window[i] = shift == 0 ? high : (high << shift) | (low >> (64 - shift));
    }
    const Wide third = static_cast<Wide>(m) * window[2];
    const Wide second = static_cast<Wide>(m) * window[1] + (third >> 64);
    const std::uint64_t first = m * window[0] + static_cast<std::uint64_t>(second >> 64);

    // The first two bits are quarters, the others a fraction of one: the nearest quarter is taken.
    auto quarter = static_cast<std::uint32_t>(first >> 62);
    const auto middle = static_cast<std::uint64_t>(second);
    Wide fraction = (static_cast<Wide>((first << 2) | (middle >> 62)) << 64) |
                    ((middle << 2) | (static_cast<std::uint64_t>(third) >> 62));
    const bool past_half = (fraction >> 127) != 0;
    if (past_half) {
        fraction = -fraction;
        ++quarter;
    }

    // fraction = top 2^(-64 - zeros), times pi / 2 = kHalfPi 2^-63.
    constexpr std::uint64_t kHalfPi = 0xc90fdaa22168c235;
    const auto high_word = static_cast<std::uint64_t>(fraction >> 64);
    const int zeros = high_word != 0 ? std::countl_zero(high_word) : 63;
    const auto top = static_cast<std::uint64_t>((fraction << zeros) >> 64);
    const Wide product = static_cast<Wide>(top) * kHalfPi;
    const auto scale = [](int exponent) {
        return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
    };
    const auto upper = static_cast<double>(static_cast<std::uint64_t>(product >> 75));
    const auto lower =
        static_cast<double>(static_cast<std::uint64_t>(product >> 22) & ((1ULL << 53) - 1));
    const double sign = past_half != std::signbit(angle) ? -1.0 : 1.0;
    if (std::signbit(angle)) {
        quarter = 0U - quarter;
    }
    return {quarter & 3U,
            sign * upper * scale(75 - 127 - zeros),
            sign * lower * scale(22 - 127 - zeros)};
}

}  // namespace

QuarterTurns quarter_turns(double angle) {
    return std::abs(angle) < kFewQuarters ? by_parts(angle) : by_window(angle);
}

}  // namespace zoned::elementary
