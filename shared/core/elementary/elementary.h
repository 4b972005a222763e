// Elementary functions with the same bits on all computers: only sums, products, quotients, square
// roots and whole numbers take part, in one order. C libraries differ from each other in the last
// bit, and from processor to processor in one library.
#pragma once

namespace zoned::elementary {

/// Errors are bounds in units in the last place (ulp) of the result, for all arguments where no
/// range stands beside them; tests/unit/elementary measures them. Of floats they hold because the
/// computation is one of doubles, whose last step rounds. Special values are those of C (annex F).
///
/// Methods: arguments are reduced as in J.-M. Muller, "Elementary Functions", 3rd ed., chapter 11:
/// with pi / 2 in parts of 33 bits (Cody and Waite) up to 2^20, with a window of the bits of 2 / pi
/// beyond (Payne and Hanek). Then the series of Taylor follow, cut where the rest is below 2^-57 of
/// the result (2^-41 for floats), and sums that keep what the first term's rounding loses.

struct SineCosine {
    double sine = 0.0;
    double cosine = 1.0;
};

struct SineCosineFloat {
    float sine = 0.0F;
    float cosine = 1.0F;
};

/// Both at the price of one. Angles in rad. 1 ulp; floats 0.501 ulp.
[[nodiscard]] SineCosine sincos(double angle);
[[nodiscard]] SineCosineFloat sincos(float angle);
[[nodiscard]] double sin(double angle);
[[nodiscard]] float sin(float angle);
[[nodiscard]] double cos(double angle);
[[nodiscard]] float cos(float angle);

/// 3 ulp.
[[nodiscard]] double tan(double angle);

/// The angle of the point (x, y), -pi..pi. 2 ulp; floats 0.501 ulp.
[[nodiscard]] double atan2(double y, double x);
[[nodiscard]] float atan2(float y, float x);

/// 0..pi, for arguments of -1..1. 4 ulp; floats 0.501 ulp.
[[nodiscard]] double acos(double cosine);
[[nodiscard]] float acos(float cosine);

/// 1 ulp; floats 0.501 ulp.
[[nodiscard]] double exp(double x);
[[nodiscard]] float exp(float x);

/// e^x - 1, 2 ulp; floats 0.501 ulp.
[[nodiscard]] double expm1(double x);
[[nodiscard]] float expm1(float x);

/// The natural logarithm, 1 ulp; floats 0.501 ulp.
[[nodiscard]] double log(double x);
[[nodiscard]] float log(float x);

/// x^y for x >= 0: 2 + 3 |y log x| ulp, floats 0.501 ulp.
[[nodiscard]] double pow(double x, double y);
[[nodiscard]] float pow(float x, float y);

/// sqrt(x^2 + y^2), 1.25 ulp where no square overflows or underflows (2^-500..2^500); floats 0.501
/// ulp everywhere.
[[nodiscard]] double hypot(double x, double y);
[[nodiscard]] float hypot(float x, float y);

}  // namespace zoned::elementary
