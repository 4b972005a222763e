// TurnIntegrals: integrals over a turn at a constant rate, without cancellation for small angles.
// Body-axes dead reckoning and turning accelerations use them.
#pragma once

#include "shared/core/elementary/elementary.h"

#include <cmath>

namespace zoned::motion {

/// Integrals of exp([w]x s), plain and weighted, over s in [0, t], for theta = |w| t, in the scale
/// of a unit rate and a unit time; with n = w / |w|, [w]x the cross product with w:
///
///   I1 = integral of exp        = t   (sine I + versine t [w]x + arc t^2 w w^T)
///   I2 = integral of (t-s) exp  = t^2 (versine I + arc t [w]x + sagitta t^2 w w^T)
///
/// Source: the matrices R1 and R2 of IEEE 1278.1-2012, annex E; I1 = R1, I2 = t R1 - R2.
struct TurnIntegrals {
    double sine = 1.0;            ///< sin(x) / x
    double versine = 0.5;         ///< (1 - cos x) / x^2
    double arc = 1.0 / 6.0;       ///< (x - sin x) / x^3
    double sagitta = 1.0 / 24.0;  ///< (x^2 / 2 - 1 + cos x) / x^4
};

/// The integrals at `theta` >= 0, rad, to some units in the last place at any angle: below 1.5 by
/// the series of sine and cosine, sum of (-1)^k x^(2k) / (2k + j)!, where the closed forms lose
/// digits with 1 / x^4; above it by the closed forms, which lose a factor of ten at most.
inline TurnIntegrals turn_integrals(double theta) {
    TurnIntegrals i;
    if (theta < 1.5) {
        // tails[j - 1] = sum over k of (-1)^k x^(2k) / (2k + j)! for j = 1..4, by Horner's rule.
        // The twelfth term is below 2.25^12 / 25! = 1e-21.
        const double square = theta * theta;
        double tails[4];
        for (int j = 1; j <= 4; ++j) {
            double sum = 1.0;
            for (int k = 12; k >= 1; --k) {
                const double step = 2.0 * k + j;
                sum = 1.0 - sum * square / (step * (step - 1.0));
            }
            constexpr double kFactorial[4] = {1.0, 2.0, 6.0, 24.0};
            tails[j - 1] = sum / kFactorial[j - 1];
        }
        i.sine = tails[0];
        i.versine = tails[1];
        i.arc = tails[2];
        i.sagitta = tails[3];
    } else {
        const auto [sine, cosine] = elementary::sincos(theta);
        const double square = theta * theta;
        i.sine = sine / theta;
        i.versine = (1.0 - cosine) / square;
        i.arc = (theta - sine) / (square * theta);
        i.sagitta = (0.5 * square - 1.0 + cosine) / (square * square);
    }
    return i;
}

}  // namespace zoned::motion
