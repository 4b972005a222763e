#include "shared/core/elementary/elementary.h"
#include "shared/core/elementary/quarter_turns.h"

#include <array>
#include <cmath>
#include <limits>

namespace zoned::elementary {

namespace {

/// Of x + low, |x| <= pi / 4 and a little. What is added to x is at most a tenth of it, so that its
/// roundings count a tenth. The first term left out is below 2^-62 of the result.
double sine_of_rest(double x, double low) {
    constexpr double k3 = -1.0 / 6.0;
    constexpr double k5 = 1.0 / 120.0;
    constexpr double k7 = -1.0 / 5040.0;
    constexpr double k9 = 1.0 / 362880.0;
    constexpr double k11 = -1.0 / 39916800.0;
    constexpr double k13 = 1.0 / 6227020800.0;
    constexpr double k15 = -1.0 / 1307674368000.0;
    constexpr double k17 = 1.0 / 355687428096000.0;
    const double z = x * x;
    const double zz = z * z;
    const double upper = (k11 + z * k13) + zz * (k15 + z * k17);
    const double sum = k3 + (z * (k5 + z * k7) + zz * z * (k9 + z * upper));
    return x + (x * z * sum + low * (1.0 - 0.5 * z));
}

/// 1 - z / 2 is rounded first, and what it lost is added to the other terms.
double cosine_of_rest(double x, double low) {
    constexpr double k4 = 1.0 / 24.0;
    constexpr double k6 = -1.0 / 720.0;
    constexpr double k8 = 1.0 / 40320.0;
    constexpr double k10 = -1.0 / 3628800.0;
    constexpr double k12 = 1.0 / 479001600.0;
    constexpr double k14 = -1.0 / 87178291200.0;
    constexpr double k16 = 1.0 / 20922789888000.0;
    const double z = x * x;
    const double zz = z * z;
    const double upper = (k12 + z * k14) + zz * k16;
    const double sum = k4 + (z * k6 + zz * ((k8 + z * k10) + zz * upper));
    const double half = 0.5 * z;
    const double first = 1.0 - half;
    return first + (((1.0 - first) - half) + (zz * sum - x * low));
}

/// For floats: the first terms left out are below 2^-45 and 2^-41.
double short_sine(double x) {
    constexpr double k3 = -1.0 / 6.0;
    constexpr double k5 = 1.0 / 120.0;
    constexpr double k7 = -1.0 / 5040.0;
    constexpr double k9 = 1.0 / 362880.0;
    constexpr double k11 = -1.0 / 39916800.0;
    constexpr double k13 = 1.0 / 6227020800.0;
    const double z = x * x;
    const double zz = z * z;
    return x + x * z * ((k3 + z * k5) + zz * ((k7 + z * k9) + zz * (k11 + z * k13)));
}

double short_cosine(double x) {
    constexpr double k4 = 1.0 / 24.0;
    constexpr double k6 = -1.0 / 720.0;
    constexpr double k8 = 1.0 / 40320.0;
    constexpr double k10 = -1.0 / 3628800.0;
    constexpr double k12 = 1.0 / 479001600.0;
    const double z = x * x;
    const double zz = z * z;
    return (1.0 - 0.5 * z) + zz * ((k4 + z * k6) + zz * ((k8 + z * k10) + zz * k12));
}

/// sin and cos of an angle from those of its rest: exchanged in odd quarters, the signs by quarter.
/// Without branches, which angles at random would mislead.
template <class Both, class Number>
Both turned_by(std::uint32_t quarter, Number sine, Number cosine) {
    const bool odd = (quarter & 1U) != 0;
    const Number first = odd ? cosine : sine;
    const Number second = odd ? sine : cosine;
    constexpr std::array<Number, 4> kSineSign = {1, 1, -1, -1};
    constexpr std::array<Number, 4> kCosineSign = {1, -1, -1, 1};
    return {kSineSign[quarter] * first, kCosineSign[quarter] * second};
}

QuarterTurns turns_of_float(float angle) {
    const auto exact = static_cast<double>(angle);
    return std::abs(exact) < kFewQuarters ? few_quarter_turns(exact) : quarter_turns(exact);
}

}  // namespace

SineCosine sincos(double angle) {
    if (!std::isfinite(angle)) {
        constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
        return {kNone, kNone};
    }
    // Below it, the square is nothing beside 1; zero keeps its sign.
    if (std::abs(angle) < 0x1p-27) {
        return {angle, 1.0};
    }
    const QuarterTurns t = quarter_turns(angle);
    return turned_by<SineCosine>(
        t.quarter, sine_of_rest(t.high, t.low), cosine_of_rest(t.high, t.low));
}

SineCosineFloat sincos(float angle) {
    if (!std::isfinite(angle)) {
        constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
        return {kNone, kNone};
    }
    if (std::abs(angle) < 0x1p-13F) {
        return {angle, 1.0F};
    }
    const QuarterTurns t = turns_of_float(angle);
    return turned_by<SineCosineFloat>(t.quarter,
                                      static_cast<float>(short_sine(t.high)),
                                      static_cast<float>(short_cosine(t.high)));
}

double sin(double angle) {
    return sincos(angle).sine;
}

float sin(float angle) {
    return sincos(angle).sine;
}

double cos(double angle) {
    return sincos(angle).cosine;
}

float cos(float angle) {
    return sincos(angle).cosine;
}

double tan(double angle) {
    const SineCosine both = sincos(angle);
    return both.sine / both.cosine;
}

}  // namespace zoned::elementary
