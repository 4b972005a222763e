#include "shared/core/elementary/elementary.h"
#include "shared/core/elementary/quarter_turns.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace zoned::elementary {

namespace {

// The first 32 bits of log 2, whose products with exponents are exact, and the rest.
constexpr double kLog2 = 0x1.62e42ff000000p-1;
constexpr double kLog2Rest = -0x1.718432a1b0e26p-35;

/// 2^exponent, -1022..1023.
double power_of_two(int exponent) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
}

/// x 2^exponent for x of about 1, rounded once where the result is subnormal.
double scaled(double x, int exponent) {
    if (exponent < -1021) {
        return x * power_of_two(exponent + 100) * 0x1p-100;
    }
    return exponent > 1023 ? 2.0 * x * power_of_two(exponent - 1) : x * power_of_two(exponent);
}

/// x = exponent log 2 + rest, and e^rest - 1 as rest + more; |rest| is at most log(2) / 2.
struct Reduced {
    int exponent;
    double rest;
    double more;
};

/// For |x| < 800. The series of e^r - 1 - r is cut after r^13 / 13!, the next term below 2^-57.
Reduced reduced(double x) {
    constexpr double kPerLog2 = 0x1.71547652b82fep+0;
    const double whole = nearest_whole(x * kPerLog2);
    const double high = x - whole * kLog2;
    const double low = whole * kLog2Rest;
    const double r = high - low;
    const double lost = (high - r) - low;
    const double z = r * r;
    const double zz = z * z;
    const double from2 = 1.0 / 2.0 + r * (1.0 / 6.0);
    const double from4 = 1.0 / 24.0 + r * (1.0 / 120.0);
    const double from6 = 1.0 / 720.0 + r * (1.0 / 5040.0);
    const double from8 = 1.0 / 40320.0 + r * (1.0 / 362880.0);
    const double from10 = 1.0 / 3628800.0 + r * (1.0 / 39916800.0);
    const double from12 = 1.0 / 479001600.0 + r * (1.0 / 6227020800.0);
    const double sum =
        (from2 + z * from4) + zz * ((from6 + z * from8) + zz * (from10 + z * from12));
    return {static_cast<int>(whole), r, z * sum + (lost + lost * r)};
}

}  // namespace

double exp(double x) {
    if (std::isnan(x)) {
        return x;
    }
    if (x > 710.0) {
        return std::numeric_limits<double>::infinity();
    }
    if (x < -746.0) {
        return 0.0;
    }
    const Reduced r = reduced(x);
    return scaled(1.0 + (r.rest + r.more), r.exponent);
}

float exp(float x) {
    return static_cast<float>(exp(static_cast<double>(x)));
}

double expm1(double x) {
    if (std::isnan(x) || x > 710.0) {
        return exp(x);
    }
    if (x < -40.0) {
        return -1.0;
    }
    if (std::abs(x) < 0x1p-54) {
        return x;
    }
    const Reduced r = reduced(x);
    const double part = r.rest + r.more;
    if (r.exponent == 0) {
        return part;
    }
    // 2^k (1 - 2^-k + part): up to k = 53 the first difference is exact.
    return r.exponent > 53 ? scaled(1.0 + part, r.exponent)
                           : scaled((1.0 - power_of_two(-r.exponent)) + part, r.exponent);
}

float expm1(float x) {
    return static_cast<float>(expm1(static_cast<double>(x)));
}

/// x = 2^k (1 + f), 1 + f from sqrt(1/2) to sqrt(2), and s = f / (2 + f): log(1 + f) =
/// 2 (s + s^3 / 3 + s^5 / 5 + ...), cut where the rest is below 2^-60 of it. 2 s = f - s f keeps f,
/// which is exact.
double log(double x) {
    if (std::isnan(x) || x < 0.0) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    if (x == 0.0) {
        return -std::numeric_limits<double>::infinity();
    }
    if (std::isinf(x)) {
        return x;
    }
    int shift = 0;
    if (x < std::numeric_limits<double>::min()) {
        x *= 0x1p54;
        shift = 54;
    }
    constexpr std::uint64_t kRootHalf = 0x3fe6a09e667f3bcd;
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const auto k = static_cast<std::int64_t>(bits - kRootHalf) >> 52;
    const auto m = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(k) << 52));
    const double f = m - 1.0;
    const double s = f / (2.0 + f);
    const double z = s * s;
    const double zz = z * z;
    const double from3 = 2.0 / 3.0 + z * (2.0 / 5.0);
    const double from7 = 2.0 / 7.0 + z * (2.0 / 9.0);
    const double from11 = 2.0 / 11.0 + z * (2.0 / 13.0);
    const double from15 = 2.0 / 15.0 + z * (2.0 / 17.0);
    const double from19 = 2.0 / 19.0 + z * (2.0 / 21.0);
    const double sum =
        z * ((from3 + zz * from7) + zz * zz * ((from11 + zz * from15) + zz * zz * from19));
    const double half = 0.5 * f * f;
    const auto exponent = static_cast<double>(k - shift);
    return exponent * kLog2 + (f - (half - (s * (half + sum) + exponent * kLog2Rest)));
}

float log(float x) {
    return static_cast<float>(log(static_cast<double>(x)));
}

double pow(double x, double y) {
    return x == 1.0 || y == 0.0 ? 1.0 : exp(y * log(x));
}

float pow(float x, float y) {
    return static_cast<float>(pow(static_cast<double>(x), static_cast<double>(y)));
}

double hypot(double x, double y) {
    return std::sqrt(x * x + y * y);
}

float hypot(float x, float y) {
    return static_cast<float>(hypot(static_cast<double>(x), static_cast<double>(y)));
}

}  // namespace zoned::elementary
