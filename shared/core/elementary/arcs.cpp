#include "shared/core/elementary/elementary.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace zoned::elementary {

namespace {

/// A number as the sum of two doubles.
struct Pair {
    double high;
    double low;
};

constexpr Pair kHalfTurn = {0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
constexpr Pair kQuarterTurn = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};

/// The arc whose tangent is i / 16.
constexpr std::array<Pair, 17> kArcs = {{{0.0, 0.0},
                                         {0x1.ff55bb72cfdeap-5, -0x1.c934d86d23f1dp-60},
                                         {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
                                         {0x1.7b97b4bce5b02p-3, 0x1.347b0b4f881cap-58},
                                         {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
                                         {0x1.362773707ebccp-2, -0x1.963a544b672d8p-57},
                                         {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
                                         {0x1.a64eec3cc23fdp-2, -0x1.24dec1b50b7ffp-56},
                                         {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
                                         {0x1.0657e94db30d0p-1, -0x1.d5b495f6349e6p-56},
                                         {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
                                         {0x1.345f01cce37bbp-1, 0x1.1021137c71102p-55},
                                         {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
                                         {0x1.5d58987169b18p-1, 0x1.0028e4bc5e7cap-57},
                                         {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
                                         {0x1.819d0b7158a4dp-1, -0x1.bf76229d3b917p-56},
                                         {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55}}};

/// base + sign (arc + rest), |rest| at most the least arc: the first sum is rounded, and what it
/// lost is added to the low parts.
double assembled(const Pair& base, double sign, const Pair& arc, double rest) {
    const double high = base.high + sign * arc.high;
    const double lost = sign * arc.high - (high - base.high);
    return high + ((lost + (base.low + sign * arc.low)) + sign * rest);
}

/// base + sign atan(less / more), 0 <= less <= more, both far from overflow and underflow. With
/// c = i / 16 near the quotient q: atan q = atan c + atan((q - c) / (1 + c q)), the latter at most
/// 1 / 32, by a series whose first term left out is below 2^-63 of it.
double arc_of_quotient(double less, double more, const Pair& base, double sign) {
    const auto i = static_cast<std::uint32_t>(16.0 * (less / more) + 0.5);
    const double c = 0x1p-4 * static_cast<double>(i);
    // The product with the upper digits is exact, and so is the difference from it.
    const auto more_high =
        std::bit_cast<double>(std::bit_cast<std::uint64_t>(more) & ~((1ULL << 26) - 1));
    const double numerator = (less - c * more_high) - c * (more - more_high);
    const double x = numerator / (more + c * less);
    const double z = x * x;
    const double upper = (1.0 / 9.0) + z * (-1.0 / 11.0);
    const double sum = -1.0 / 3.0 + z * (1.0 / 5.0 + z * (-1.0 / 7.0 + z * upper));
    return assembled(base, sign, kArcs[i], x + x * z * sum);
}

/// Of magnitudes, by the octant that they lie in.
double arc_of(double y, double x, bool behind) {
    if (y > x) {
        return arc_of_quotient(x, y, kQuarterTurn, behind ? 1.0 : -1.0);
    }
    return behind ? arc_of_quotient(y, x, kHalfTurn, -1.0) : arc_of_quotient(y, x, {0.0, 0.0}, 1.0);
}

/// Of magnitudes of which one or both are infinite.
double arc_at_infinity(double y, double x, bool behind) {
    const bool far_x = std::isinf(x);
    const bool far_y = std::isinf(y);
    if (far_x && far_y) {
        return behind ? 0.75 * kHalfTurn.high : 0.25 * kHalfTurn.high;
    }
    if (far_y) {
        return kQuarterTurn.high;
    }
    return behind ? kHalfTurn.high : 0.0;
}

}  // namespace

double atan2(double y, double x) {
    if (std::isnan(y) || std::isnan(x)) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    double up = std::abs(y);
    double across = std::abs(x);
    const bool behind = std::signbit(x);
    double arc = 0.0;
    if (std::isinf(up) || std::isinf(across)) {
        arc = arc_at_infinity(up, across, behind);
    } else if (up == 0.0 && across == 0.0) {
        arc = behind ? kHalfTurn.high : 0.0;
    } else {
        // Products do not overflow then, and small numbers keep their digits.
        const double larger = up > across ? up : across;
        const double scale = larger > 0x1p900 ? 0x1p-200 : larger < 0x1p-800 ? 0x1p300 : 1.0;
        arc = arc_of(up * scale, across * scale, behind);
    }
    return std::copysign(arc, y);
}

float atan2(float y, float x) {
    return static_cast<float>(atan2(static_cast<double>(y), static_cast<double>(x)));
}

double acos(double cosine) {
    return atan2(std::sqrt((1.0 - cosine) * (1.0 + cosine)), cosine);
}

float acos(float cosine) {
    return static_cast<float>(acos(static_cast<double>(cosine)));
}

}  // namespace zoned::elementary
